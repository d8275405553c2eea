// The pose of an image against the map: robust refinement from a guess, and PnP without one.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/rigid3.h"
#include "motion/scale_fit.h"

namespace eifmap {

struct AbsolutePoseOptions {
  int min_inliers = 15;     // fewer: no pose
  double gate_sigma = 3.5;  // an inlier's whitened reprojection error is below this
  int max_iterations = 20;  // of the refinement
  double bisquare = 4.685;  // tuning constant, in units of the spread
  // PnP alone:
  double ransac_threshold_px = 3.0;   // RANSAC of OpenCV's P3P, with a fixed state
  double ransac_confidence = 0.9999;  // that one sample was free of outliers
  int ransac_iterations = 300;        // at most
  int seed = 1;                       // of RANSAC

  std::string problem() const;
};

struct AbsolutePose {
  Reason reason = Reason::kTooFewInliers;  // kNone: accepted
  Rigid3 world_from_camera;
  // Of (w, dc) as in retract(); given the map, whose own uncertainty enters by the sigmas only.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<std::uint8_t> inlier;  // one per observation
  int num_inliers = 0;

  bool ok() const { return reason == Reason::kNone; }
};

// Gauss-Newton / Levenberg with bisquare weights on the reprojection error, spread estimated by a
// clamped MAD; points behind the camera are outliers.
AbsolutePose refine_absolute_pose(const Rigid3& world_from_guess,
                                  std::span<const MapObservation> observations,
                                  const AbsolutePoseOptions& options);

// The pose as it is: who agrees with it, and how certain that makes it.
AbsolutePose judge_absolute_pose(const Rigid3& world_from_camera,
                                 std::span<const MapObservation> observations,
                                 const AbsolutePoseOptions& options);

// The fallback: P3P RANSAC over all observations, then refine_absolute_pose.
AbsolutePose solve_pnp(std::span<const MapObservation> observations, double radians_per_pixel,
                       const AbsolutePoseOptions& options);

}  // namespace eifmap
