// What a plane in view says: does it explain the matches, and which motions does it leave?
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "motion/relative_pose.h"

namespace eifmap {

struct Homography {
  Eigen::Matrix3d i_from_j = Eigen::Matrix3d::Identity();  // x_i ~ i_from_j x_j; scale undefined
  std::vector<std::uint8_t> inlier;                        // one per match
  double inlier_ratio = 0;  // of the chosen matches, those within their noise
};

// Robust least squares over the chosen matches (`chosen`: one flag per match), most of which must
// agree with one homography. Ratio 0 of nothing.
Homography fit_homography(std::span<const Correspondence> matches,
                          std::span<const std::uint8_t> chosen);

// The motions that a homography R + t n' / distance of a plane n' x_j = distance admits with the
// plane's points (the homography's inliers) in front of both cameras: at most two, the one with
// more points in front first. Nothing when the homography is a rotation's, which shows no
// translation. No covariance.
std::vector<RelativePose> decompose_homography(const Homography& homography,
                                               std::span<const Correspondence> matches);

}  // namespace eifmap
