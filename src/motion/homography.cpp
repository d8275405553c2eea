#include <Eigen/Eigenvalues>
#include <cmath>

#include "motion/epipolar.h"
#include "motion/robust.h"

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

}  // namespace

double homography_inlier_ratio(std::span<const Correspondence> matches,
                               std::span<const std::uint8_t> inlier) {
  // Nearly all or nothing is asked, so least squares over all with a few rounds of bisquare weights
  // does, and no search is needed.
  std::vector<double> weights(matches.size()), errors;
  for (std::size_t k = 0; k < matches.size(); ++k) weights[k] = inlier[k] ? 1 : 0;
  int chosen = 0, explained = 0;
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    for (std::size_t k = 0; k < matches.size(); ++k)
      if (weights[k] > 0) add_constraints(matches[k], weights[k], normal);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
    const Eigen::Matrix<double, 9, 1> row_major = solver.eigenvectors().col(0);
    Eigen::Matrix3d h;
    h << row_major.head<3>().transpose(), row_major.segment<3>(3).transpose(),
        row_major.tail<3>().transpose();

    errors.assign(matches.size(), 0);
    std::vector<double> of_chosen;
    chosen = explained = 0;
    for (std::size_t k = 0; k < matches.size(); ++k) {
      if (!inlier[k]) continue;
      errors[k] = transfer_error(matches[k], h);
      of_chosen.push_back(errors[k]);
      ++chosen;
      explained += errors[k] < kGate;
    }
    const double limit = 4.685 * std::max(1.0, kSpreadFromMedian2d * take_median(of_chosen));
    for (std::size_t k = 0; k < matches.size(); ++k)
      weights[k] = inlier[k] ? bisquare_weight(errors[k], limit) : 0;
  }
  return chosen == 0 ? 0 : static_cast<double>(explained) / chosen;
}

}  // namespace eifmap
