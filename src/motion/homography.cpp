#include "motion/homography.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/robust.h"

namespace eifmap {
namespace {

constexpr double kGate = 3.0349;  // 99 % of the norms of two whitened normal errors

// Sum of a weighted match's two linear constraints x_i x (H x_j) = 0 on the nine numbers of H, rows
// first.
void add_constraints(const Correspondence& m, double weight, Eigen::Matrix<double, 9, 9>& normal) {
  const Eigen::RowVector3d x = m.x_j.homogeneous().transpose();
  Eigen::Matrix<double, 2, 9> a;
  a << x, Eigen::RowVector3d::Zero(), -m.x_i.x() * x,  //
      Eigen::RowVector3d::Zero(), x, -m.x_i.y() * x;
  normal.noalias() += weight * a.transpose() * a;
}

// Whitened distance of x_i from H x_j; j's noise carried over at the scale of H there.
double transfer_error(const Correspondence& m, const Eigen::Matrix3d& h) {
  const Eigen::Vector3d y = h * m.x_j.homogeneous();
  if (std::abs(y.z()) < 1e-12) return 1e9;
  const Eigen::Vector2d x = y.hnormalized();
  const Eigen::Matrix2d jacobian =
      (h.topLeftCorner<2, 2>() - x * h.bottomLeftCorner<1, 2>()) / y.z();
  const double variance =
      m.sigma_i * m.sigma_i + 0.5 * jacobian.squaredNorm() * m.sigma_j * m.sigma_j;
  return (m.x_i - x).norm() / std::sqrt(variance);
}

// Weighted least squares (direct linear transform; coordinates of order 1 need no scaling).
Eigen::Matrix3d fit(std::span<const Correspondence> matches, const std::vector<double>& weights) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t k = 0; k < matches.size(); ++k)
    if (weights[k] > 0) add_constraints(matches[k], weights[k], normal);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  return h.reshaped<Eigen::RowMajor>(3, 3);
}

}  // namespace

Homography fit_homography(std::span<const Correspondence> matches,
                          std::span<const std::uint8_t> chosen) {
  std::vector<double> weights(matches.size()), errors;
  for (std::size_t k = 0; k < matches.size(); ++k) weights[k] = chosen[k] ? 1 : 0;
  Homography homography;
  homography.inlier.assign(matches.size(), 0);
  // Nearly all or nothing is asked, so least squares over all with a few rounds of bisquare weights
  // does, and no search is needed.
  for (int round = 0; round < 4; ++round) {
    homography.i_from_j = fit(matches, weights);
    errors.clear();
    int explained = 0;
    for (std::size_t k = 0; k < matches.size(); ++k) {
      if (!chosen[k]) continue;
      errors.push_back(transfer_error(matches[k], homography.i_from_j));
      homography.inlier[k] = errors.back() < kGate;
      explained += homography.inlier[k];
    }
    if (errors.empty()) return homography;
    homography.inlier_ratio = static_cast<double>(explained) / static_cast<double>(errors.size());

    auto error = errors.begin();
    std::vector<double> sizes = errors;
    const double limit = kBisquare * std::max(1.0, kSpreadFromMedian2d * take_median(sizes));
    for (std::size_t k = 0; k < matches.size(); ++k)
      if (chosen[k]) weights[k] = bisquare_weight(*error++, limit);
  }
  return homography;
}

}  // namespace eifmap
