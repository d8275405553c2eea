// The two kinds of measurement that the filter fuses, h_g(X) of [WD10] (6), with their Jacobians.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "geometry/rigid3.h"
#include "motion/relative_pose.h"

namespace eifmap {

// A relative-pose observation of [WD10] II: R and T of camera j in camera i, fused together since
// they are correlated.
struct RelativePoseMeasurement {
  Eigen::Quaterniond i_from_j = Eigen::Quaterniond::Identity();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit, of j's centre in i
  Eigen::Matrix<double, 5, 5> sqrt_information = Eigen::Matrix<double, 5, 5>::Identity();
};

// Whitens by the Cholesky factor of the inverse covariance. False when the covariance is not
// positive definite.
bool make_measurement(const RelativePose& pose, RelativePoseMeasurement& measurement);

struct RelativePoseLinearization {
  Eigen::Matrix<double, 5, 1> residual = Eigen::Matrix<double, 5, 1>::Zero();  // whitened z - h(x)
  Eigen::Matrix<double, 5, 6> d_i = Eigen::Matrix<double, 5, 6>::Zero();  // whitened dh / d(w, dc)
  Eigen::Matrix<double, 5, 6> d_j = Eigen::Matrix<double, 5, 6>::Zero();  // of the two poses
};

// False when the two centres coincide: the direction is undefined.
bool linearize(const RelativePoseMeasurement& measurement, const Rigid3& world_from_i,
               const Rigid3& world_from_j, RelativePoseLinearization& out);

}  // namespace eifmap
