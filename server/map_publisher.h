// The server's side of a published map: updates go out in parts at a pace, and what a client did
// not get goes out again. What was sent is kept as the clients have it, so that one that comes late
// gets the very map that the others hold. Knows no network and no clock.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/outbox.h"
#include "published/map_request.h"
#include "published/published_map.h"

namespace eifmap {

class MapPublisher {
 public:
  using TimePoint = Outbox::TimePoint;

  struct Options {
    std::size_t max_part_bytes = 32 * 1024;
    int bytes_per_s = 5'000'000;
    // Of updates that can be sent again as they were; who misses an older one gets the whole map.
    // So there is no use in more of them than twice the whole map, or of a small one this.
    std::size_t max_kept_bytes = 16u << 20, small_map_bytes = 1u << 20;
  };
  explicit MapPublisher(const Options& options) : options_(options), outbox_(options.bytes_per_s) {}

  // The next update: a whole map (base_seq -1), or from map().seq() on; else std::invalid_argument.
  // Its digest is computed here. What waits of maps before a whole one is not sent any more.
  void publish(map_part_t update, const std::string& channel);

  // Sends again, to everybody, what a client has not got: what is named, or the whole map. What
  // waits to be sent, or has just been sent, is not sent twice: several may ask.
  void answer(const map_request_t& request, TimePoint now);

  // As Outbox's.
  std::optional<TimePoint> send_due(TimePoint now, const Outbox::Send& send) {
    return outbox_.send_due(now, send);
  }
  std::int64_t drop_all() { return outbox_.drop_all(); }

  const PublishedMap& map() const { return map_; }  // as published so far

  struct Counts {
    std::int64_t requests = 0;       // answered
    std::int64_t parts_again = 0;    // sent again
    std::int64_t whole_maps = 0;     // put together because somebody asked
    std::int64_t parts_dropped = 0;  // of maps that were replaced before they had left
  };
  const Counts& counts() const { return counts_; }
  std::size_t kept_bytes() const { return bytes_after(-1); }  // of updates, to be sent again

  // Nothing is sent again within this time.
  static constexpr auto kRepeat = std::chrono::milliseconds(50);

 private:
  struct Sent {
    std::int64_t seq = -1;
    bool whole = false;
    std::vector<std::shared_ptr<OutgoingMessage>> parts;
    std::size_t bytes = 0;
  };

  Sent encoded(const map_part_t& update) const;
  const Sent* sent(std::int64_t seq, bool whole) const;
  std::size_t bytes_after(std::int64_t seq) const;
  void forget_old();
  bool add_missing(const missing_part_t& missing,
                   std::vector<std::shared_ptr<OutgoingMessage>>& wanted) const;
  bool find_wanted(const map_request_t& request,
                   std::vector<std::shared_ptr<OutgoingMessage>>& wanted) const;
  void add_whole(std::vector<std::shared_ptr<OutgoingMessage>>& wanted);

  const Options options_;
  Outbox outbox_;
  PublishedMap map_;
  std::string channel_;
  std::deque<Sent> updates_;   // the last ones, one after the other, to map_.seq()
  std::optional<Sent> whole_;  // the newest whole map that updates_ lead on from
  Counts counts_;
};

}  // namespace eifmap
