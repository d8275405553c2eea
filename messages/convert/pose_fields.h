// position[3] and quaternion[4] (w x y z) of the wire <-> Rigid3; covariance[36] <-> a matrix.
#pragma once

#include "geometry/rigid3.h"
#include "wire/limits.h"

namespace eifmap {

inline void write_pose(const Rigid3& pose, double position[3], double quaternion[4]) {
  for (int i = 0; i < 3; ++i) position[i] = pose.translation[i];
  quaternion[0] = pose.rotation.w();
  quaternion[1] = pose.rotation.x();
  quaternion[2] = pose.rotation.y();
  quaternion[3] = pose.rotation.z();
}

// The very numbers: nothing is normalized.
inline Rigid3 read_pose(const double position[3], const double quaternion[4]) {
  return {{quaternion[0], quaternion[1], quaternion[2], quaternion[3]},
          {position[0], position[1], position[2]}};
}

inline void write_covariance(const Eigen::Matrix<double, 6, 6>& matrix, double covariance[36]) {
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor>::Map(covariance) = matrix;
}

inline Eigen::Matrix<double, 6, 6> read_covariance(const double covariance[36]) {
  return Eigen::Matrix<double, 6, 6, Eigen::RowMajor>::Map(covariance);
}

inline bool valid_pose(const double position[3], const double quaternion[4]) {
  return all_finite(position, 3) && valid_quaternion(quaternion);
}

}  // namespace eifmap
