// Landmarks looked for where a pose predicts them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// How far from its predicted place a landmark is looked for.
struct SearchGate {
  double radius = 0;  // normalized image coordinates: never further than this
  // Where the pose's error (w, dc), given the map, is known: within so many sigmas of the
  // innovation, which is the pose's, the landmark's and the keypoint's error together.
  std::optional<Eigen::Matrix<double, 6, 6>> pose_covariance;
  double sigmas = 0;
};

// The landmarks of `tracks` that have a keypoint of the same Laplacian sign within the gate around
// their predicted place and a descriptor that fits. One keypoint per landmark and one landmark per
// keypoint; by track ascending.
std::vector<LandmarkSight> search_landmarks(const Map& map, const ObservedFrame& observed,
                                            const Rigid3& world_from_camera,
                                            const std::vector<int>& tracks, const SearchGate& gate,
                                            const MatchOptions& options);

}  // namespace eifmap
