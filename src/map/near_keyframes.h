// Which keyframes see what a frame sees: by where they are, and by what they share.
#pragma once

#include <vector>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// Keyframes in use from which much the same is in view: within a quarter of `depth` (map units) and
// 0.3 rad of `world_from_camera`, the nearest first, at most `count`, and none of `but`.
std::vector<int> near_keyframes(const Map& map, const Rigid3& world_from_camera, double depth,
                                int count, const std::vector<int>& but);

// How many of these landmarks each keyframe sees.
std::vector<int> num_seen(const Map& map, const std::vector<LandmarkSight>& sights);

}  // namespace eifmap
