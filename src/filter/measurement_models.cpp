#include "filter/measurement_models.h"

#include <Eigen/Cholesky>

namespace eifmap {

bool make_measurement(const RelativePose& pose, RelativePoseMeasurement& measurement) {
  const Eigen::LLT<Eigen::Matrix<double, 5, 5>> llt(pose.covariance);
  if (llt.info() != Eigen::Success) return false;
  measurement.i_from_j = pose.i_from_j;
  measurement.direction = pose.direction;
  // Sigma = L L', so L^-1 whitens.
  measurement.sqrt_information = llt.matrixL().solve(Eigen::Matrix<double, 5, 5>::Identity());
  return measurement.sqrt_information.allFinite();
}

bool linearize(const RelativePoseMeasurement& measurement, const Rigid3& world_from_i,
               const Rigid3& world_from_j, RelativePoseLinearization& out) {
  const Eigen::Matrix3d i_from_world = world_from_i.matrix().transpose();
  const Eigen::Vector3d p = i_from_world * (world_from_j.translation - world_from_i.translation);
  const double length = p.norm();
  if (!(length > 1e-12)) return false;

  // Rotation: h - z = Log(R_measured' R_i' R_j).
  const Eigen::Quaterniond predicted = world_from_i.rotation.conjugate() * world_from_j.rotation;
  const Eigen::Vector3d w = so3_log(measurement.i_from_j.conjugate() * predicted);
  const Eigen::Matrix3d jr_inverse = so3_right_jacobian_inverse(w);

  // Direction: h - z in the tangent plane at the measured direction.
  const Eigen::Vector3d t = p / length;
  const Eigen::Matrix<double, 2, 3> basis = sphere_basis(measurement.direction).transpose();
  const Eigen::Matrix<double, 2, 3> d_p =
      basis * (Eigen::Matrix3d::Identity() - t * t.transpose()) / length;

  Eigen::Matrix<double, 5, 1> error;
  error << w, basis * t;
  out.d_i.setZero();
  out.d_j.setZero();
  out.d_i.topLeftCorner<3, 3>() = -jr_inverse * predicted.toRotationMatrix().transpose();
  out.d_j.topLeftCorner<3, 3>() = jr_inverse;
  out.d_i.bottomLeftCorner<2, 3>() = d_p * skew(p);
  out.d_i.bottomRightCorner<2, 3>() = -d_p * i_from_world;
  out.d_j.bottomRightCorner<2, 3>() = d_p * i_from_world;

  out.residual = -(measurement.sqrt_information * error);
  out.d_i = measurement.sqrt_information * out.d_i;
  out.d_j = measurement.sqrt_information * out.d_j;
  return true;
}

}  // namespace eifmap
