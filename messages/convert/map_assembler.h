// The client's side of a published map: parts in, in any order and more than once; the map out.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "convert/map_message.h"

namespace eifmap {

// The map of one server and camera as far as it has arrived.
struct PublishedMap {
  std::int64_t server_epoch = 0, map_id = 0, map_epoch = 0, seq = -1;
  std::map<std::int64_t, KeyframeView> keyframes;            // by id
  std::map<std::int64_t, LandmarkView> landmarks;            // by id
  std::set<std::pair<std::int64_t, std::int64_t>> observed;  // (keyframe, landmark)

  // In the map's frame; landmarks whose anchor has not arrived are left out.
  std::vector<MapPoint> points() const;
};

class MapAssembler {
 public:
  enum class Outcome {
    kIncomplete,  // parts of this update are missing yet
    kApplied,     // the map has moved on
    kWaiting,     // whole, but an update before it is missing
    kIgnored,     // a duplicate, older than the map, of an older server's run, or contradictory
  };

  // `max_waiting`: whole or partial updates kept while an earlier one is missing. When there are
  // more, the missing one is given up: counted as lost, and the oldest whole one is applied.
  explicit MapAssembler(std::size_t max_waiting = 64) : max_waiting_(max_waiting) {}

  Outcome add(const MapPart& part);

  // No more parts will come: applies the whole updates that wait, oldest first.
  void finish();

  const PublishedMap& map() const { return map_; }
  std::int64_t lost_updates() const { return lost_; }  // at least; 0: the map is as published

 private:
  struct Pending {
    MapUpdate update;        // of the parts so far
    std::vector<bool> have;  // by part
    std::size_t missing = 0;
  };

  bool take_map(const MapPart& part);
  bool is_next(const Pending& pending) const;
  void apply(const MapUpdate& update);
  bool apply_ready();
  void skip_gap();

  std::size_t max_waiting_;
  PublishedMap map_;
  std::int64_t newest_epoch_ = 0;            // map_epoch, of the parts of this map
  std::map<std::int64_t, Pending> pending_;  // by seq
  std::int64_t lost_ = 0;
};

}  // namespace eifmap
