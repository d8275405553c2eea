// Whether a place is that of a map, by what of the map should be seen there: places that only have
// something in common differ in the rest.
#pragma once

#include <string>
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

  void add(const SeenAgain& other) {
    expected += other.expected;
    seen += other.seen;
    in_holes += other.in_holes;
  }
  // Enough of them is seen, and all over: no more of them are in holes than chance makes.
  bool is_all_over(const LostOptions& options) const;
  std::string in_words() const;
};

// Of the landmarks `tracks` (ascending) what was observed from the pose.
SeenAgain seen_again(const Map& map, const std::vector<int>& tracks, const ObservedFrame& observed,
                     const Rigid3& world_from_camera, const SafeView& view,
                     const MapperOptions& options);
// Of those around the keyframe.
SeenAgain seen_again(const Map& map, int keyframe, const ObservedFrame& observed,
                     const Rigid3& world_from_camera, const SafeView& view,
                     const MapperOptions& options);

}  // namespace eifmap
