#include "sequence/consistency.h"

#include <Eigen/Cholesky>
#include <limits>

namespace eifmap {

TruthInMap::TruthInMap(const Rigid3& world_from_first, const Rigid3& world_from_second,
                       const Eigen::Vector3d& second_centre)
    : first_from_world_(world_from_first.inverse()) {
  const Eigen::Vector3d true_centre = first_from_world_ * world_from_second.translation;
  scale_ = second_centre.squaredNorm() / second_centre.dot(true_centre);
}

Rigid3 TruthInMap::operator()(const Rigid3& world_from_camera) const {
  Rigid3 pose = first_from_world_ * world_from_camera;
  pose.translation *= scale_;
  return pose;
}

PoseVector pose_error(const Rigid3& estimate, const Rigid3& truth) {
  PoseVector error;
  error << truth.translation - estimate.translation,
      so3_log(estimate.rotation.conjugate() * truth.rotation);
  return error;
}

double nees(const PoseVector& error, const PoseMatrix& covariance) {
  const Eigen::LLT<PoseMatrix> factor(covariance);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return error.dot(factor.solve(error));
}

}  // namespace eifmap
