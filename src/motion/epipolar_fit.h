// The weighted least squares behind refining a relative pose and its covariance.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "motion/relative_pose.h"

namespace eifmap {

using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;
using RowVector5d = Eigen::Matrix<double, 1, 5>;

// A match that takes part.
struct EpipolarMember {
  std::size_t match;
  double trust = 1;  // weight besides the bisquare one
};

struct EpipolarNormal {
  Matrix5d information = Matrix5d::Zero();
  Vector5d gradient = Vector5d::Zero();  // the step is information^-1 gradient
  double cost = 0;
};

// Of the members' whitened Sampson residuals with bisquare weights that vanish at `limit`; to
// (w, ab) of `pose`.
EpipolarNormal linearize(std::span<const Correspondence> matches,
                         const std::vector<EpipolarMember>& members, const RelativePose& pose,
                         double limit);

// i_from_j Exp(w), sphere_retract(direction, ab).
RelativePose moved(const RelativePose& pose, const Vector5d& step);

// Fill in covariance and sigma_direction of a `pose` that minimizes the members' cost; `spread`:
// the standard deviation of their whitened residuals. False when the information is singular.
//
// Linear: (H' M^-1 H)^-1 with M the information as measured and H = M - N the part of it that is
// not noise: the noise N of the Jacobians enters the gradient, but does not hold the pose in place.
bool set_linear_covariance(std::span<const Correspondence> matches,
                           const std::vector<EpipolarMember>& members, double spread,
                           RelativePose& pose);

// [WD10] III-A: the Unscented transform of the 4 N numbers measured. Each sigma point moves one of
// them by +-sqrt(3) standard deviations (S. Julier, J. Uhlmann: n + kappa = 3), and the pose is
// refined anew from where it is, members and their trust fixed. Costs about 8 N passes over the
// matches.
bool set_unscented_covariance(std::span<const Correspondence> matches,
                              const std::vector<EpipolarMember>& members, double spread,
                              RelativePose& pose);

// The greater standard deviation of the direction, from the pose's covariance; false when not
// finite.
bool set_sigma_direction(RelativePose& pose);

}  // namespace eifmap
