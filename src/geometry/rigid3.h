// Rigid transforms whose names check themselves when composed: `a_from_b` takes coordinates in b to
// coordinates in a, and a_from_c = a_from_b * b_from_c. See notation.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace eifmap {

// x_in_a = rotation * x_in_b + translation. In `world_from_camera` the translation is the camera's
// centre in the world.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Rigid3() = default;
  Rigid3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : rotation(q), translation(t) {}

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  Rigid3 operator*(const Rigid3& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }
  Rigid3 inverse() const {
    const Eigen::Quaterniond q = rotation.conjugate();
    return {q, -(q * translation)};
  }
  Eigen::Matrix3d matrix() const { return rotation.toRotationMatrix(); }
};

// [v]x, the matrix of the cross product.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

// Rotation vector (rad) <-> unit quaternion; w >= 0 in the result of exp's argument's short way.
Eigen::Quaterniond so3_exp(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d so3_log(const Eigen::Quaterniond& rotation);

// J_r with Log(Exp(w) Exp(d)) ~ w + J_r(w)^-1 d.
Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& rotation_vector);

// The pose's error as everywhere in eifmap: a rotation vector w in the camera's own frame, R <- R
// Exp(w), and the displacement of the centre in world coordinates, c <- c + dc.
Rigid3 retract(const Rigid3& world_from_camera, const Eigen::Vector3d& w,
               const Eigen::Vector3d& dc);

// Two unit vectors that span the tangent plane of the sphere at the unit vector t (3x2); a fixed
// rule, so that the same t always gives the same basis.
Eigen::Matrix<double, 3, 2> sphere_basis(const Eigen::Vector3d& t);

// t moved on the sphere by the tangent coordinates ab (rad) in sphere_basis(t).
Eigen::Vector3d sphere_retract(const Eigen::Vector3d& t, const Eigen::Vector2d& ab);

}  // namespace eifmap
