// Maps that the camera was lost in, and may come back to.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "map/live_map.h"
#include "map/map_merge.h"
#include "map/measurement_desk.h"

namespace eifmap {

struct KeptMap {
  std::int64_t map_id = 0;
  LiveMap live;                    // as it was left
  std::int64_t epoch = 0;          // FrameResult::map_epoch then
  std::deque<PlacedFrame> frames;  // of the desk for measurements
};

class KeptMaps {
 public:
  // At most so many, 0 or more.
  explicit KeptMaps(int most) : most_(most) {}

  // Returns the one that has to go for it, if one has: that with the fewest keyframes, of several
  // the one left first.
  std::optional<KeptMap> keep(KeptMap map);
  KeptMap take(std::int64_t map_id);  // throws std::out_of_range where it is not kept

  KeptMap* find(std::int64_t map_id);  // null where it is not kept
  // Of the maps in turn, one image after the other; null of none.
  KeptMap* next_to_try();

  const std::vector<KeptMap>& all() const { return maps_; }  // by when they were left
  std::vector<KeptMap>& all() { return maps_; }
  std::vector<KeptView> views() const;
  int size() const { return static_cast<int>(maps_.size()); }
  void forget_frames() {
    for (KeptMap& map : maps_) map.frames.clear();
  }

 private:
  int most_;
  std::vector<KeptMap> maps_;
  int turn_ = 0;
};

}  // namespace eifmap
