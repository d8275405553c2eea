#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/rigid3.h"
#include "motion/epipolar_fit.h"
#include "motion/epipolar_geometry.h"
#include "motion/robust.h"

namespace eifmap {
namespace {

// Of the information on a direction of the parameters, the share that may be noise (see
// EpipolarGeometry::jacobian_noise) before the covariance stops growing.
constexpr double kMaxNoiseShare = 0.8;

bool set_sigma_direction(RelativePose& pose) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> of_direction(
      pose.covariance.bottomRightCorner<2, 2>(), Eigen::EigenvaluesOnly);
  pose.sigma_direction = std::sqrt(of_direction.eigenvalues().maxCoeff());
  return std::isfinite(pose.sigma_direction);
}

// Gauss-Newton from a solution whose data has changed a little.
RelativePose refine_again(std::span<const Correspondence> matches,
                          const std::vector<EpipolarMember>& members, RelativePose pose,
                          double limit) {
  constexpr int kSteps = 6;
  for (int k = 0; k < kSteps; ++k) {
    const EpipolarNormal normal = linearize(matches, members, pose, limit);
    const Vector5d step = normal.information.ldlt().solve(normal.gradient);
    if (!step.allFinite()) break;
    pose = moved(pose, step);
    // A thousandth of the standard deviation that one sigma point stands for.
    if (step.dot(normal.gradient) * static_cast<double>(members.size()) < 1e-6) break;
  }
  return pose;
}

}  // namespace

bool set_linear_covariance(std::span<const Correspondence> matches,
                           const std::vector<EpipolarMember>& members, double spread,
                           RelativePose& pose) {
  const double limit = kPoseBisquare * spread;
  const Eigen::LLT<Matrix5d> measured(linearize(matches, members, pose, limit).information);
  if (measured.info() != Eigen::Success || !(measured.rcond() > 1e-12)) return false;
  Matrix5d noise = Matrix5d::Zero();
  const EpipolarGeometry geometry(pose);
  for (const EpipolarMember& m : members) {
    const Correspondence& match = matches[m.match];
    noise.bottomRightCorner<2, 2>() +=
        m.trust * bisquare_weight(geometry.residual(match), limit) * geometry.jacobian_noise(match);
  }
  // In coordinates where M = L L' is the identity, N is symmetric with eigenvalues 0 to 1.
  const Matrix5d half = measured.matrixL().solve(noise);
  const Matrix5d share = measured.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix5d> solver(share);
  const Vector5d kept = 1 - solver.eigenvalues().array().min(kMaxNoiseShare);
  const Matrix5d root =
      measured.matrixU().solve(Matrix5d(solver.eigenvectors() * kept.cwiseInverse().asDiagonal()));
  pose.covariance = std::max(1.0, spread * spread) * root * root.transpose();
  return set_sigma_direction(pose);
}

bool set_unscented_covariance(std::span<const Correspondence> matches,
                              const std::vector<EpipolarMember>& members, double spread,
                              RelativePose& pose) {
  const double claimed = std::max(1.0, spread);
  const double limit = kPoseBisquare * claimed;
  const Eigen::LLT<Matrix5d> measured(linearize(matches, members, pose, limit).information);
  if (measured.info() != Eigen::Success || !(measured.rcond() > 1e-12)) return false;
  // Where the data as it is has its minimum: a step of the last refinement left there would show in
  // every sigma point.
  const RelativePose centre = refine_again(matches, members, pose, limit);
  const double length = std::sqrt(3.0) * claimed;
  const Eigen::Matrix<double, 3, 2> basis = sphere_basis(pose.direction);
  std::vector<Correspondence> disturbed(matches.begin(), matches.end());
  Matrix5d sum = Matrix5d::Zero();
  const auto add = [&](double& number, double change) {
    const double before = number;
    number += change;
    const RelativePose image = refine_again(disturbed, members, centre, limit);
    Vector5d step;
    step << so3_log(centre.i_from_j.conjugate() * image.i_from_j),
        basis.transpose() * (image.direction - centre.direction);
    sum.noalias() += step * step.transpose();
    number = before;
  };
  for (const EpipolarMember& m : members) {
    Correspondence& match = disturbed[m.match];
    for (const double side : {-length, length})
      for (const int axis : {0, 1}) {
        add(match.x_i[axis], side * match.sigma_i);
        add(match.x_j[axis], side * match.sigma_j);
      }
  }
  // About the centre's own image and not the mean, whose weight 1 - 4 N / 3 is far below 0 (the
  // modified form of Julier and Uhlmann, which cannot be indefinite).
  pose.covariance = sum / 6;
  return set_sigma_direction(pose);
}

}  // namespace eifmap
