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

// Remembers what was last sent and compares. Sent again is a keyframe that moved by more than a
// small part of the scene's depth; a landmark that moved in its anchor's frame by a quarter of its
// sigma, by half a pixel for a keyframe that sees it, or by a hundredth of its depth, or whose
// covariance has changed by a tenth: asked of those that are seen from other keyframes than before,
// and of some others in turn. Observations are sent once, and once more when they are gone.
class MapNews {
 public:
  // Fills everything but map_id and map_epoch.
  MapUpdate since_last(const Map& map);
  void begin_anew();  // the next is a whole map

 private:
  struct Sent {
    LandmarkView landmark;
    std::vector<Sight> sights;
  };

  void compare_keyframes(const Map& map, MapUpdate& update);
  void compare_landmarks(const Map& map, MapUpdate& update);
  bool compare_sights(const Map& map, int track, Sent& sent, MapUpdate& update);
  bool is_its_turn(int track) const;
  void keep_changed(const Map& map, MapUpdate& update);

  std::int64_t seq_ = -1;
  bool is_whole_ = true;               // the next one
  std::vector<Rigid3> sent_poses_;     // by keyframe
  std::map<std::int64_t, Sent> sent_;  // by landmark
  std::int64_t turn_ = 0;              // landmark whose covariance is compared next
};

}  // namespace eifmap
