// What of the map changed since it was last published.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "map/map.h"
#include "map_view.h"

namespace eifmap {

// All keyframes, or landmarks, as they are now, with their covariances where they are known.
std::vector<KeyframeView> keyframe_views(const Map& map);
std::vector<LandmarkView> landmark_views(const Map& map);

// Remembers what was last sent and compares: a keyframe is sent again when it moved by more than a
// small part of the scene's depth, a landmark when it moved in its anchor's frame. What is sent
// goes with its covariance of now.
class MapNews {
 public:
  // Fills everything but map_id and map_epoch.
  MapUpdate since_last(const Map& map);
  // The next is a whole map. Its number is past `seq`, too, where others have been published since.
  void begin_anew(std::int64_t seq = -1);

 private:
  void compare_keyframes(const Map& map, MapUpdate& update);
  void compare_landmarks(const Map& map, MapUpdate& update);

  std::int64_t seq_ = -1;
  bool is_whole_ = true;                       // the next one
  std::vector<Rigid3> sent_poses_;             // by keyframe
  std::map<std::int64_t, LandmarkView> sent_;  // by landmark
};

}  // namespace eifmap
