#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/robust.h"
#include "motion/epipolar_fit.h"
#include "motion/epipolar_geometry.h"

namespace eifmap {
namespace {

// Of the information on a direction of the parameters, the share that may be noise (see
// EpipolarGeometry::jacobian_noise) before the covariance stops growing.
constexpr double kMaxNoiseShare = 0.8;

}  // namespace

bool set_sigma_direction(RelativePose& pose) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> of_direction(
      pose.covariance.bottomRightCorner<2, 2>(), Eigen::EigenvaluesOnly);
  pose.sigma_direction = std::sqrt(of_direction.eigenvalues().maxCoeff());
  return std::isfinite(pose.sigma_direction);
}

bool set_linear_covariance(std::span<const Correspondence> matches,
                           const std::vector<EpipolarMember>& members, double spread,
                           RelativePose& pose) {
  const double limit = kBisquare * spread;
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

}  // namespace eifmap
