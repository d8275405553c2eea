// What arrived of each publisher's frames, by the numbers that it gives them.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <vector>

namespace eifmap {

// A frame's header as it came, before anything else of it is judged.
struct FrameArrival {
  std::int64_t publisher = 0;    // 0: one that does not say
  std::int64_t seq = -1;         // -1: none
  std::int64_t time_us = 0;      // capture, the publisher's clock
  std::int64_t received_us = 0;  // the server's clock; 0 unknown
};

struct StreamCounts {
  std::int64_t publisher = 0;
  std::int64_t frames = 0;
  std::int64_t missing = 0;     // numbers passed over and not seen since
  std::int64_t reordered = 0;   // came after a higher number
  std::int64_t duplicates = 0;  // of a number that had come already
  // Least time from capture to reception: the offset of the clocks and the shortest way.
  std::optional<std::int64_t> clock_offset_us = {};
};

class StreamBook {
 public:
  // `dropped_before`: frames that the server itself dropped since the one before. They did arrive.
  // False when the number had come already, or is so far back that nobody knows.
  bool note(const FrameArrival& arrival, std::int64_t dropped_before);

  // The last publisher first; of a few before.
  const std::vector<StreamCounts>& streams() const { return counts_; }
  std::int64_t missing() const;                        // of all, those forgotten included
  std::int64_t restarts() const { return restarts_; }  // of a publisher, or another one

 private:
  // Numbers back from the highest that may still come late.
  static constexpr std::size_t kWindow = 1024;
  static constexpr std::size_t kMaxStreams = 8;

  void begin(std::int64_t publisher);
  void begin_numbers();
  bool count(const FrameArrival& arrival, std::int64_t dropped_before, StreamCounts& counts);

  std::vector<StreamCounts> counts_;
  std::int64_t first_ = -1, highest_ = -1;  // of the last publisher, since it began
  std::int64_t highest_time_us_ = 0;        // of that frame
  std::bitset<kWindow> seen_;               // bit i: highest_ - i has come
  std::int64_t forgotten_missing_ = 0, restarts_ = 0;
};

}  // namespace eifmap
