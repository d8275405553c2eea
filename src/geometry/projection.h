// A world point seen by a camera, in normalized image coordinates, with Jacobians: the one
// measurement model of the map, shared by triangulation, pose refinement and the filter.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "geometry/rigid3.h"

namespace eifmap {

// Of (x/z, y/z) = `at` to the camera's turn w as in retract(): p(w) = Exp(-w) p ~ p + p x w. The
// depth cancels: turning a camera shows no depth.
inline Eigen::Matrix<double, 2, 3> derivative_to_turn(const Eigen::Vector2d& at) {
  const double u = at.x(), v = at.y();
  Eigen::Matrix<double, 2, 3> derivative;
  derivative << u * v, -(1 + u * u), v, 1 + v * v, -u * v, -u;
  return derivative;
}

// A world -> camera transform prepared for many points: one rotation matrix instead of one
// quaternion product per point.
class Projector {
 public:
  explicit Projector(const Rigid3& world_from_camera)
      : camera_from_world_(world_from_camera.matrix().transpose()),
        centre_(world_from_camera.translation) {}

  // Writes (x/z, y/z) of `point` (world) to `x`. Jacobians when asked for: `d_pose` to (w, dc) as
  // in retract(), `d_point` to the point's displacement in world. False, with nothing written, when
  // the point lies behind the camera or within 1e-6 rad of its image plane.
  bool operator()(const Eigen::Vector3d& point, Eigen::Vector2d& x,
                  Eigen::Matrix<double, 2, 6>* d_pose = nullptr,
                  Eigen::Matrix<double, 2, 3>* d_point = nullptr) const {
    const Eigen::Vector3d p = camera_from_world_ * (point - centre_);
    if (!(p.z() > 1e-6 * p.norm())) return false;
    const double inverse_z = 1 / p.z();
    const double u = p.x() * inverse_z, v = p.y() * inverse_z;
    x << u, v;
    if (!d_pose && !d_point) return true;

    // d(u, v)/dp, times the rotation: to the point's displacement, and to minus the centre's.
    Eigen::Matrix<double, 2, 3> to_point;
    to_point.row(0) = inverse_z * (camera_from_world_.row(0) - u * camera_from_world_.row(2));
    to_point.row(1) = inverse_z * (camera_from_world_.row(1) - v * camera_from_world_.row(2));
    if (d_pose) {
      d_pose->leftCols<3>() = derivative_to_turn(x);
      d_pose->rightCols<3>() = -to_point;
    }
    if (d_point) *d_point = to_point;
    return true;
  }

  // z of the point (world) in the camera.
  double depth(const Eigen::Vector3d& point) const {
    return camera_from_world_.row(2).dot(point - centre_);
  }

 private:
  Eigen::Matrix3d camera_from_world_;
  Eigen::Vector3d centre_;
};

// The same for a single point.
inline bool project(const Rigid3& world_from_camera, const Eigen::Vector3d& point,
                    Eigen::Vector2d& x, Eigen::Matrix<double, 2, 6>* d_pose = nullptr,
                    Eigen::Matrix<double, 2, 3>* d_point = nullptr) {
  return Projector(world_from_camera)(point, x, d_pose, d_point);
}

}  // namespace eifmap
