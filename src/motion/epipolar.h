// Parts of the relative pose that are not its interface: the five-point search, depths of matches,
// the check for a plane.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "motion/relative_pose.h"

namespace eifmap {

enum class DepthSign { kUndecided, kInFront, kBehind };

// Whether a match's point lies in front of both cameras; undecided while its parallax is not three
// times its noise, since the depth of a distant point has a random sign. `i_from_j` is
// pose.i_from_j as a matrix.
DepthSign depth_sign(const Correspondence& match, const Eigen::Matrix3d& i_from_j,
                     const Eigen::Vector3d& direction);

// [WD10] Algorithm 1: five-point RANSAC, then the one of the essential matrix's four poses that
// puts the points in front of both cameras. A start for refine_relative_pose: good to a few
// degrees, no covariance. Nothing when the matches hold no essential matrix. `rotation` decides
// between poses that have as many points in front.
std::optional<RelativePose> search_relative_pose(std::span<const Correspondence> matches,
                                                 const Eigen::Quaterniond& rotation,
                                                 double radians_per_pixel,
                                                 const RelativePoseOptions& options);

// Share of the chosen matches (`inlier` of the pose) that one homography explains to within their
// noise.
double homography_inlier_ratio(std::span<const Correspondence> matches,
                               std::span<const std::uint8_t> inlier);

}  // namespace eifmap
