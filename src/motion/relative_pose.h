// The pose of one image relative to another from matches alone: [WD10] Algorithm 1, steps 1-2.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reason.h"

namespace eifmap {

// A match of images i and j in normalized image coordinates (x/z, y/z), with each point's standard
// deviation in the same unit.
struct Correspondence {
  Eigen::Vector2d x_i, x_j;
  double sigma_i = 0, sigma_j = 0;
};

// How the covariance of (R, T) is found. They agree where the geometry is good.
enum class RelativePoseCovariance {
  kLinear,     // microseconds at 100 matches
  kUnscented,  // tens of milliseconds there, growing with the square of the number of matches
};

struct RelativePoseOptions {
  int min_matches = 15;  // fewer: no relative pose
  // Rotation alone explains the pair: NO_BASELINE. Measured: with the five-point rotation in its
  // place, a standstill showed 300-900 px of "parallax".
  double min_median_parallax_px = 1.5;
  double max_rotation_inlier_ratio = 0.8;  // more explained by a rotation alone: NO_BASELINE
  // RANSAC
  double ransac_threshold_px = 1.0;  // at least; 2.5 sigma of the matches where that is more
  double ransac_confidence = 0.99;   // the refinement forgives a start that is not the best
  int ransac_iterations = 400;       // at most
  int seed = 1;                      // of RANSAC
  double min_inlier_ratio = 0.3;     // of the matches; fewer: no relative pose
  // How the covariance of (R, T) is found; [WD10] III-A: unscented.
  RelativePoseCovariance covariance = RelativePoseCovariance::kLinear;
  bool check_planar = true;  // fill in RelativePoseResult::planar and alternatives

  std::string problem() const;  // "" or which field is wrong and why
};

// Best rotation between two images, as if the camera had not moved.
struct RotationFit {
  Eigen::Quaterniond i_from_j = Eigen::Quaterniond::Identity();
  std::vector<std::uint8_t> inlier;  // one per correspondence
  int num_inliers = 0;
  double median_parallax = 0;  // rad, of all correspondences after the rotation is taken out
};

// Robust; needs >= 2 correspondences, else identity with 0 inliers. `radians_per_pixel` turns the
// options' pixels into normalized units.
RotationFit fit_rotation(std::span<const Correspondence> matches, double radians_per_pixel,
                         const RelativePoseOptions& options);

// The 5-DOF pose of camera j in camera i: x_in_i = i_from_j x_in_j + (unknown length) direction.
struct RelativePose {
  Eigen::Quaterniond i_from_j = Eigen::Quaterniond::Identity();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit, of j's centre in i
  // Of (w, ab): i_from_j Exp(w), sphere_retract(direction, ab); rad^2. Linear, (J' Q^-1 J)^-1, with
  // the noise of J itself allowed for, which dominates at little parallax; or unscented.
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  double sigma_direction = 0;  // rad, root of the larger eigenvalue of ab's covariance
};

// Another pose that the matches leave open.
struct RelativePoseAlternative {
  RelativePose pose;
  std::vector<std::uint8_t> inlier;  // one per correspondence
  int num_inliers = 0;
};

struct RelativePoseResult {
  Reason reason = Reason::kNone;  // kNone: `pose` is valid. kTooFewMatches, kNoBaseline (rotation
                                  // in `rotation` is good), kRelativePoseFailed
  RotationFit rotation;
  RelativePose pose;
  std::vector<std::uint8_t> inlier;  // of `pose`, one per correspondence, classified after refining
  int num_inliers = 0;
  bool planar = false;  // a homography explains the matches as well as E does: two-fold ambiguity
  // When planar: the homography's motions that are not `pose`, at most two, each refined on its own
  // inliers. Only what else is known (the map) tells which of all is the true one.
  std::vector<RelativePoseAlternative> alternatives;

  bool ok() const { return reason == Reason::kNone; }
};

// Rotation-only test first, then five-point RANSAC (OpenCV's, fixed state), cheirality, refinement
// of all 5 DOF with bisquare weights on the Sampson residual, inliers classified again, covariance.
RelativePoseResult estimate_relative_pose(std::span<const Correspondence> matches,
                                          double radians_per_pixel,
                                          const RelativePoseOptions& options);

// The refinement and covariance alone, from a start near the solution; `inlier` says which
// correspondences may take part on entry (empty: all) and which agree on return. False when fewer
// than 8 agree or the normal matrix is singular. Used for the filter's edges, whose R, T and
// covariance come from unspent measurements only.
bool refine_relative_pose(std::span<const Correspondence> matches, RelativePose& pose,
                          std::vector<std::uint8_t>& inlier, RelativePoseCovariance covariance);

// Sampson distance of a match, signed, whitened: residual / its standard deviation from sigma_i and
// sigma_j; 1x5 Jacobian to (w, ab) when asked for.
double sampson_residual(const Correspondence& match, const RelativePose& pose,
                        Eigen::Matrix<double, 1, 5>* jacobian = nullptr);

}  // namespace eifmap
