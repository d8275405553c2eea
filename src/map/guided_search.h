// Landmarks looked for where a pose predicts them.
#pragma once

#include <vector>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// The landmarks of `tracks` that have a keypoint of the same Laplacian sign within `radius`
// (normalized image coordinates) of their predicted place and a descriptor that fits. One keypoint
// per landmark and one landmark per keypoint; by track ascending.
std::vector<LandmarkSight> search_landmarks(const Map& map, const ObservedFrame& observed,
                                            const Rigid3& world_from_camera,
                                            const std::vector<int>& tracks, double radius,
                                            const MatchOptions& options);

}  // namespace eifmap
