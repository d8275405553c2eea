// What one match says of a relative pose. `EpipolarGeometry` is a pose prepared for many matches.
#pragma once

#include <Eigen/Core>

#include "motion/relative_pose.h"

namespace eifmap {

enum class DepthSign { kUndecided, kInFront, kBehind };

class EpipolarGeometry {
 public:
  explicit EpipolarGeometry(const RelativePose& pose);

  // sampson_residual() of relative_pose.h.
  double residual(const Correspondence& match,
                  Eigen::Matrix<double, 1, 5>* jacobian = nullptr) const;

  // Whether the match's point lies in front of both cameras; undecided while its parallax is below
  // three times its noise, since the depth of a distant point has a random sign.
  DepthSign depth_sign(const Correspondence& match) const;

  // The noise of a match along its epipolar lines lengthens or shortens its parallax, and with it
  // the residual's Jacobian J to ab: J'J is on average too large by this 2x2 matrix. With little
  // parallax it is most of J'J.
  Eigen::Matrix2d jacobian_noise(const Correspondence& match) const;

 private:
  // The epipolar lines of a match in i and j (E x_j and E' x_i), and the first-order variance of
  // the algebraic residual x_i' E x_j.
  struct Lines {
    Eigen::Vector3d x_i, x_j, y, in_i, in_j;  // y = R x_j
    double variance_i, variance_j, variance;  // of the points, of the residual
  };
  Lines lines_of(const Correspondence& match) const;

  Eigen::Matrix3d r_;  // i_from_j
  Eigen::Vector3d t_;  // direction
  Eigen::Matrix<double, 3, 2> basis_;
};

}  // namespace eifmap
