#include "geometry/similarity.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <stdexcept>
#include <string>

namespace eifmap {
namespace {

void check_sizes(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b, const char* name) {
  if (a.cols() != b.cols() || a.cols() == 0)
    throw std::invalid_argument(std::string(name) +
                                ": wanted as many points in a as in b, and one at least");
}

struct Centred {
  Centred(const Eigen::Matrix3Xd& a_points, const Eigen::Matrix3Xd& b_points)
      : mean_a(a_points.rowwise().mean()),
        mean_b(b_points.rowwise().mean()),
        a(a_points.colwise() - mean_a),
        b(b_points.colwise() - mean_b),
        cross(a * b.transpose()) {}

  Eigen::Matrix3d rotation(const DirectionPair* direction) const {
    Eigen::Matrix3d all = cross;
    if (direction) all += a.norm() * b.norm() * direction->in_a * direction->in_b.transpose();
    return nearest_rotation(all);
  }

  Eigen::Vector3d mean_a, mean_b;
  Eigen::Matrix3Xd a, b;
  Eigen::Matrix3d cross;
};

}  // namespace

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m, Eigen::Vector3d* signed_values) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  if (signed_values) *signed_values = svd.singularValues().cwiseProduct(sign);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

Similarity fit_similarity(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                          const DirectionPair* direction) {
  check_sizes(a, b, "fit_similarity");
  const Centred centred(a, b);
  Similarity result;
  result.rotation = centred.rotation(direction);
  const double squared = centred.b.squaredNorm();
  if (squared > 0) result.scale = (result.rotation.transpose() * centred.cross).trace() / squared;
  result.translation = centred.mean_a - result.scale * (result.rotation * centred.mean_b);
  return result;
}

Rigid3 fit_rigid(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                 const DirectionPair* direction) {
  check_sizes(a, b, "fit_rigid");
  const Centred centred(a, b);
  const Eigen::Matrix3d rotation = centred.rotation(direction);
  return {Eigen::Quaterniond(rotation).normalized(), centred.mean_a - rotation * centred.mean_b};
}

}  // namespace eifmap
