#include "geometry/rigid3.h"

#include <cmath>

namespace eifmap {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Quaterniond so3_exp(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  // sin(a/2)/a by its series near zero, where the quotient is 0/0.
  const double s = angle < 1e-6 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  return Eigen::Quaterniond(std::cos(angle / 2), s * rotation_vector.x(), s * rotation_vector.y(),
                            s * rotation_vector.z())
      .normalized();
}

Eigen::Vector3d so3_log(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1 : 1;  // q and -q are one rotation: take the short way
  const Eigen::Vector3d v = sign * rotation.vec();
  const double n = v.norm(), w = sign * rotation.w();
  if (n < 1e-9) return 2 * v;
  return (2 * std::atan2(n, w) / n) * v;
}

Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const Eigen::Matrix3d k = skew(rotation_vector);
  const double c =
      angle < 1e-4 ? 1.0 / 12
                   : 1 / (angle * angle) - (1 + std::cos(angle)) / (2 * angle * std::sin(angle));
  return Eigen::Matrix3d::Identity() + 0.5 * k + c * k * k;
}

Rigid3 retract(const Rigid3& world_from_camera, const Eigen::Vector3d& w,
               const Eigen::Vector3d& dc) {
  return {(world_from_camera.rotation * so3_exp(w)).normalized(),
          world_from_camera.translation + dc};
}

Eigen::Matrix<double, 3, 2> sphere_basis(const Eigen::Vector3d& t) {
  // Start from the axis that t is least along, so that the cross product never degenerates.
  int axis = 0;
  t.cwiseAbs().minCoeff(&axis);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = t.cross(Eigen::Vector3d::Unit(axis)).normalized();
  basis.col(1) = t.cross(basis.col(0)).normalized();
  return basis;
}

Eigen::Vector3d sphere_retract(const Eigen::Vector3d& t, const Eigen::Vector2d& ab) {
  const Eigen::Vector3d v = sphere_basis(t) * ab;
  const double n = v.norm();
  const double s = n < 1e-9 ? 1 : std::sin(n) / n;
  return (std::cos(n) * t + s * v).normalized();
}

}  // namespace eifmap
