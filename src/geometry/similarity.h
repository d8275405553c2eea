// Similarity and rigid transforms between two sets of points: S. Umeyama, Least-Squares Estimation
// of Transformation Parameters Between Two Point Patterns, PAMI 1991.
#pragma once

#include <Eigen/Core>

#include "geometry/rigid3.h"

namespace eifmap {

// x_in_a = scale * rotation * x_in_b + translation.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const {
    return scale * (rotation * x) + translation;
  }
  Similarity operator*(const Similarity& other) const {
    return {scale * other.scale, rotation * other.rotation, *this * other.translation};
  }
  Similarity inverse() const {
    const Eigen::Matrix3d back = rotation.transpose();
    return {1 / scale, back, -(back * translation) / scale};
  }
  // Without the scale: of a camera's pose that of a camera which stands there.
  Rigid3 rigid() const { return {Eigen::Quaterniond(rotation).normalized(), translation}; }
  static Similarity of(const Rigid3& pose, double scale = 1) {
    return {scale, pose.matrix(), pose.translation};
  }
};

// A direction that is known in both frames; unit vectors.
struct DirectionPair {
  Eigen::Vector3d in_a, in_b;
};

// The a_from_b that minimizes the sum of |a_k - a_from_b * b_k|^2. Columns are points; as many in a
// as in b, else std::invalid_argument. Scale 1 when all of b is one point. `direction`, where there
// is one, counts for the rotation as much as all points together: what they leave open, as the turn
// about the line that all of them are on, it decides.
Similarity fit_similarity(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                          const DirectionPair* direction = nullptr);
// The same with scale 1.
Rigid3 fit_rigid(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                 const DirectionPair* direction = nullptr);

// The rotation nearest to m in the Frobenius norm. `signed_values`: m's singular values, the last
// negative where the nearest orthogonal matrix is a reflection.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m,
                                 Eigen::Vector3d* signed_values = nullptr);

}  // namespace eifmap
