// What the filter holds of each feature and each measurement.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/measurement_models.h"

namespace eifmap {

// A feature seen from a pose.
struct PointMeasurement {
  int pose = 0;
  Eigen::Vector2d x = Eigen::Vector2d::Zero();  // normalized image coordinates
  double sigma = 0;                             // of x, each axis, same unit

  // Frozen at the last linearization; whitened, and scaled by the robust weight's root.
  bool linearized = false;
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  // at the linearization point
  Eigen::Matrix<double, 2, 6> d_pose = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Matrix<double, 2, 3> d_landmark = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // what is left of z - h at the mean
};

struct FilterLandmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world
  // Given the poses, V^-1, as of the last update or promotion: a lower bound of the marginal.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<PointMeasurement> measurements;  // at most one per pose; empty: removed

  // A measurement has come, gone or been linearized since V^-1 was computed.
  bool changed = true;
  Eigen::Matrix3d v_inverse = Eigen::Matrix3d::Zero();  // of the frozen linearizations
};

struct FilterEdge {
  int i = 0, j = 0;
  RelativePoseMeasurement measurement;
  bool linearized = false;
  RelativePoseLinearization linearization;  // scaled by the robust weight's root; the residual is
                                            // what is left of z - h at the mean
  double squared_error = 0;                 // whitened, at the mean, without the weight
};

}  // namespace eifmap
