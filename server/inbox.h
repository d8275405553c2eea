// Where the receiving thread leaves a camera's messages for its mapping thread: the only state that
// they share.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "wire/bytes.h"
#include "wire/channel.h"

namespace eifmap {

enum class InputMode {
  kNewest,    // a new frame replaces one that still waits
  kLossless,  // every frame, in order, as long as there is room
};

struct Received {
  Channel channel;
  std::vector<std::uint8_t> bytes;
  std::chrono::steady_clock::time_point time;
  std::int64_t received_us = 0;     // the same by the time of day
  std::int64_t dropped_before = 0;  // frames that were dropped between the one before and this
};

class Inbox {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  // Replaces nothing of its kind.
  static bool each_counts(ChannelKind kind) {
    return kind == ChannelKind::kMeasurement || kind == ChannelKind::kRelativeRequest ||
           kind == ChannelKind::kMapRequest;
  }

  struct Counts {
    std::int64_t frames = 0;                // that arrived
    std::int64_t dropped = 0;               // of them, replaced by a newer one or without room
    std::int64_t measurements_dropped = 0;  // for want of room
  };

  // More than `max_bytes` never wait, except a single larger message.
  Inbox(InputMode mode, std::size_t max_bytes) : mode_(mode), max_bytes_(max_bytes) {}

  // Moves in a copy of the bytes. A calibration replaces one that waits, measurements and requests
  // nothing. What has no room is dropped and counted, unless when lossless the caller may wait for
  // it: not the taker itself, and not one whose waiting holds up other cameras. After close()
  // nothing is taken in.
  void put(const Channel& channel, Bytes bytes, bool may_wait = true);

  // The next message, in the order of their arrival; waits for one until `deadline`.
  std::optional<Received> take(TimePoint deadline);

  // Nothing more goes in, and waiting ends.
  void close();

  // Waits until everything that came in was taken and the taker came back for more, or `deadline`.
  bool wait_until_idle(TimePoint deadline);

  Counts counts() const;

 private:
  static bool is_frame(const Channel& channel) {
    return channel.kind == ChannelKind::kImage || channel.kind == ChannelKind::kFeatures;
  }
  void replace(const Channel& channel);

  const InputMode mode_;
  const std::size_t max_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Received> queue_;
  std::size_t queued_bytes_ = 0;
  Counts counts_;
  std::int64_t dropped_since_put_ =
      0;  // frames, since the last one that went in and is there still
  bool taker_waits_ = false;
  bool closed_ = false;
};

}  // namespace eifmap
