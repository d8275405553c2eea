// The searches behind estimate_relative_pose.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "motion/relative_pose.h"

namespace eifmap {

// [WD10] Algorithm 1: five-point RANSAC, then the one of the essential matrix's four poses that
// puts the points in front of both cameras. A start for refine_relative_pose: good to a few
// degrees, no covariance. Nothing when the matches hold no essential matrix. `rotation` decides
// between poses that have as many points in front.
std::optional<RelativePose> search_relative_pose(std::span<const Correspondence> matches,
                                                 const Eigen::Quaterniond& rotation,
                                                 double radians_per_pixel,
                                                 const RelativePoseOptions& options);

}  // namespace eifmap
