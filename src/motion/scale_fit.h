// The offsetting observation model: the length of the last step from the map. [WD10] (2)-(5) and
// section III-D; votes first, since the paper's plain fit breaks at 50 % outliers.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/rigid3.h"
#include "reason.h"

namespace eifmap {

// A map feature seen in the new image.
struct MapObservation {
  Eigen::Vector3d point;  // X_f, world
  Eigen::Vector2d x;      // where it is seen, normalized image coordinates
  double sigma = 0;       // of x, each axis, same unit; includes the point's own uncertainty
};

enum class ScaleFitMethod {
  kVote,  // every feature votes for d first; the modes start the fit, whose spread is clamped
  // [WD10] III-D to the letter, from the guess alone with the spread as it comes: for comparison,
  // since it breaks down at 50 % outliers
  kPlain,
};

struct ScaleFitOptions {
  ScaleFitMethod method = ScaleFitMethod::kVote;
  int min_inliers = 15;             // fewer: no scale
  double min_inlier_ratio = 0.3;    // of the features; fewer: no scale
  double max_relative_sigma = 0.1;  // sigma of the baseline / baseline
  double max_runner_up = 0.7;  // votes of the second mode / votes of the first; 0 where none vote
  double bisquare = 4.685;     // tuning constant, in units of the spread
  double max_spread = 2.5;     // vote: the spread is clamped to [1, max_spread] sigma

  std::string problem() const;
};

struct ScaleFit {
  Reason reason = Reason::kScaleFitFailed;  // kNone: accepted
  // X_j(d) = X_jG + d (X_i - X_jG): 0 the guess, 1 did not move, > 1 the direction's sign was
  // wrong.
  double d = 0, sigma_d = 0;
  double baseline = 0, sigma_baseline = 0;  // map units
  Rigid3 world_from_j;                      // the guess moved to d
  std::vector<std::uint8_t> inlier;         // one per observation
  int num_inliers = 0;
  double inlier_ratio = 0, runner_up = 0;

  bool ok() const { return reason == Reason::kNone; }
};

// `world_from_guess`: P_jG on the line through `centre_i` (world) along the relative pose's
// direction. Throws std::invalid_argument when guess and centre_i coincide (the line is undefined).
ScaleFit fit_scale(const Eigen::Vector3d& centre_i, const Rigid3& world_from_guess,
                   std::span<const MapObservation> observations, const ScaleFitOptions& options);

}  // namespace eifmap
