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

}  // namespace

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m, Eigen::Vector3d* signed_values) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  if (signed_values) *signed_values = svd.singularValues().cwiseProduct(sign);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

Similarity fit_similarity(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  check_sizes(a, b, "fit_similarity");
  const auto n = static_cast<double>(a.cols());
  const Eigen::Vector3d mean_a = a.rowwise().mean(), mean_b = b.rowwise().mean();
  const Eigen::Matrix3Xd da = a.colwise() - mean_a, db = b.colwise() - mean_b;
  const double variance = db.squaredNorm() / n;
  Similarity result;
  Eigen::Vector3d values;
  result.rotation = nearest_rotation(da * db.transpose() / n, &values);
  if (variance > 0) result.scale = values.sum() / variance;
  result.translation = mean_a - result.scale * (result.rotation * mean_b);
  return result;
}

Rigid3 fit_rigid(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  check_sizes(a, b, "fit_rigid");
  const Eigen::Vector3d mean_a = a.rowwise().mean(), mean_b = b.rowwise().mean();
  const Eigen::Matrix3d rotation =
      nearest_rotation((a.colwise() - mean_a) * (b.colwise() - mean_b).transpose());
  return {Eigen::Quaterniond(rotation).normalized(), mean_a - rotation * mean_b};
}

}  // namespace eifmap
