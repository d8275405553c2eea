// Whether a place is that of a map, by what of the map should be seen there: places that only have
// something in common differ in the rest.
#pragma once

#include <vector>

#include "map/map.h"
#include "map/sight_counts.h"
#include "options.h"

namespace eifmap {

// Landmarks that the map has seen well and that the camera should see from where it is.
struct SeenAgain {
  int expected = 0, seen = 0;
  // Not seen, and none of those next to it in the image either. What a detector misses is missed
  // here and there; what is not there at all leaves a hole.
  int in_holes = 0;

  double share() const { return expected == 0 ? 0 : static_cast<double>(seen) / expected; }
  // Enough of them is seen, all over the image.
  bool is_all_over(const LostOptions& options) const;
};

// Of the landmarks around `keyframe` what was observed from the pose. `around`: keyframes, itself
// among them, whose landmarks are asked for.
SeenAgain seen_again(const Map& map, int keyframe, const ObservedFrame& observed,
                     const Rigid3& world_from_camera, const SafeView& view,
                     const MapperOptions& options, int around = 12);

}  // namespace eifmap
