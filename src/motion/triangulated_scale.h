// The length of a step from depths: the map's against those triangulated with the step's relative
// pose. What [WD10] compares its scale fit with.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/rigid3.h"
#include "motion/relative_pose.h"

namespace eifmap {

// A map feature seen in both images.
struct SeenTwice {
  Eigen::Vector3d point;  // world
  Correspondence match;
};

// The pose of j at the median of the features' ratios of depth; nothing when fewer than half of
// them, or none, can be triangulated in front of both cameras. One median and no second thought:
// plain on purpose.
std::optional<Rigid3> place_by_triangulation(const Rigid3& world_from_i, const RelativePose& pose,
                                             const std::vector<SeenTwice>& features);

}  // namespace eifmap
