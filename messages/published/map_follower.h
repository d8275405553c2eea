// The client's side of a published map: parts in, in any order and more than once; out comes the
// map exactly as it was published, and what to ask the server for where something is missing.
// Knows no network and no clock.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "published/map_part.h"
#include "published/map_request.h"
#include "published/published_map.h"

namespace eifmap {

class MapFollower {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  enum class Outcome {
    kIncomplete,  // more parts are missing
    kApplied,     // the map has moved on
    kIgnored,     // a duplicate, older than the map, of an older server's run, or contradictory
  };

  // `requester`: of the requests, random per start and not 0.
  explicit MapFollower(std::int64_t requester) : requester_(requester) {}

  Outcome take(const map_part_t& part, TimePoint now);

  // What else was published tells how far the map has come: the map_seq of poses and statuses of
  // this camera; 0: there is no map yet. `digest`: of the map as of that, where it is said.
  void hear(const std::string& camera, std::int64_t server_epoch, std::int64_t map_seq,
            TimePoint now, std::optional<std::int64_t> digest = {});

  // The map as of map().seq(), exactly as published, unless nothing has arrived yet. That of an
  // older run of the server stays until one of the new run is whole.
  const PublishedMap& map() const { return map_; }
  // Whether the server is known to be further, or of another run, or the map is not right.
  bool is_stale() const;

  // What updates did to the map since the last call.
  MapChange take_changes() { return std::exchange(changes_, {}); }

  // What is to be sent to the server now, if anything: parts are waited for for kPatience, and
  // asked for again ever more rarely. `utime`: us since the Unix epoch, for the message.
  std::optional<map_request_t> ask(TimePoint now, std::int64_t utime);

  struct Counts {
    std::int64_t updates = 0;     // applied
    std::int64_t whole_maps = 0;  // of them
    std::int64_t requests = 0;    // made
    std::int64_t wrong_digests =
        0;  // maps that were not what was published; each was asked for anew
    std::int64_t contradictions = 0;  // parts that disagree with others of their update
  };
  const Counts& counts() const { return counts_; }

  static constexpr auto kPatience = std::chrono::milliseconds(100);
  static constexpr auto kMaxPatience = std::chrono::milliseconds(1600);
  // Updates that wait for one before them; of more the last ones are let go, and asked for later.
  static constexpr std::size_t kMaxWaiting = 256;
  // Whole maps that arrive at a time.
  static constexpr int kMaxWholes = 2;

 private:
  // An update by its two ends.
  struct Step {
    std::int64_t seq = 0, base = 0;
    auto operator<=>(const Step&) const = default;
    bool is_whole() const { return base == -1; }
  };
  struct Pending {
    std::map<std::int32_t, map_part_t> parts;  // those that are there
    bool is_complete() const;
    bool agrees(const map_part_t& part) const;
    map_part_t update() const;  // all parts as one, in their order
  };

  bool take_run(std::int64_t server_epoch, TimePoint now);
  bool is_of_use(const Step& step) const;
  bool is_next(const Step& step) const;
  bool apply_ready(TimePoint now);
  void apply(const map_part_t& update);
  void note_changes(const map_part_t& update);
  void make_room();
  void drop_old_wholes();
  bool goes_by_whole() const;
  void note_progress(TimePoint now);
  void add_missing(const Step& step, map_request_t& request) const;
  const Pending* pending(const Step& step) const;
  std::optional<Step> newest_whole() const;

  std::int64_t requester_;
  std::string camera_;
  std::int64_t server_epoch_ = 0;  // the newest run heard of
  std::int64_t heard_seq_ = 0;     // the furthest of it
  PublishedMap map_;
  bool is_right_ = false;  // the map is of that run, and its digest was right
  std::map<Step, Pending> pending_;
  MapChange changes_;
  std::int64_t asked_from_ = -1;  // map_.seq() of the last request for steps
  TimePoint next_ask_{};
  std::chrono::milliseconds patience_ = kPatience;
  Counts counts_;
};

}  // namespace eifmap
