#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/rigid3.h"
#include "motion/epipolar_geometry.h"
#include "motion/robust.h"

namespace eifmap {
namespace {

using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;
using RowVector5d = Eigen::Matrix<double, 1, 5>;

constexpr std::size_t kMinInliers = 8;
constexpr double kBisquare = 4.685;   // 95 % efficient on normal residuals
constexpr double kInlierSigma = 3.0;  // of a whitened Sampson residual
// The spread of the whitened residuals is 1 if the sigmas are right; estimates beyond these come
// from outliers, or from too few points.
constexpr double kMinSpread = 0.5, kMaxSpread = 2.5;
// A match moves the pose by its leverage. Wrong matches that happen to lie near their epipolar
// lines have random, mostly huge parallax: a handful of them at 40 % outliers doubled the
// direction's error. Above this many times the median, leverage is cut (C. Mallows' weights).
constexpr double kMaxLeverage = 4;
constexpr int kRounds = 2;
// Of the information on a direction of the parameters, the share that may be noise (see
// EpipolarGeometry::jacobian_noise) before the covariance stops growing.
constexpr double kMaxNoiseShare = 0.8;

// A match that takes part.
struct Member {
  std::size_t match;
  double trust = 1;  // weight besides the bisquare one
};

struct Normal {
  Matrix5d information = Matrix5d::Zero();
  Vector5d gradient = Vector5d::Zero();
  double cost = 0;
};

Normal linearize(std::span<const Correspondence> matches, const std::vector<Member>& members,
                 const RelativePose& pose, double limit) {
  const EpipolarGeometry geometry(pose);
  Normal normal;
  RowVector5d jacobian;
  for (const Member& m : members) {
    const double residual = geometry.residual(matches[m.match], &jacobian);
    normal.cost += m.trust * bisquare_cost(residual, limit);
    const double weight = m.trust * bisquare_weight(residual, limit);
    if (weight == 0) continue;
    normal.information.noalias() += weight * jacobian.transpose() * jacobian;
    normal.gradient.noalias() -= weight * residual * jacobian.transpose();
  }
  return normal;
}

double cost_of(std::span<const Correspondence> matches, const std::vector<Member>& members,
               const RelativePose& pose, double limit) {
  const EpipolarGeometry geometry(pose);
  double cost = 0;
  for (const Member& m : members)
    cost += m.trust * bisquare_cost(geometry.residual(matches[m.match]), limit);
  return cost;
}

// Of the residuals below `limit`, clamped.
double spread_of(std::span<const Correspondence> matches, const std::vector<Member>& members,
                 const RelativePose& pose, double limit) {
  const EpipolarGeometry geometry(pose);
  std::vector<double> sizes;
  sizes.reserve(members.size());
  for (const Member& m : members) {
    const double size = std::abs(geometry.residual(matches[m.match]));
    if (size < limit) sizes.push_back(size);
  }
  return std::clamp(kSpreadFromMedian1d * take_median(sizes), kMinSpread, kMaxSpread);
}

RelativePose moved(const RelativePose& pose, const Vector5d& step) {
  RelativePose result = pose;
  result.i_from_j = (pose.i_from_j * so3_exp(step.head<3>())).normalized();
  result.direction = sphere_retract(pose.direction, step.tail<2>());
  return result;
}

// Levenberg-Marquardt from `spread` on; the spread follows the residuals in the first steps, then
// stands still so that the cost has a minimum to settle in.
void minimize(std::span<const Correspondence> matches, const std::vector<Member>& members,
              RelativePose& pose, double& spread) {
  constexpr int kSpreadSteps = 5, kSteps = 25;
  double damping = 1e-4;
  for (int iteration = 0; iteration < kSteps; ++iteration) {
    if (iteration < kSpreadSteps) spread = spread_of(matches, members, pose, kBisquare * spread);
    const double limit = kBisquare * spread;
    const Normal normal = linearize(matches, members, pose, limit);
    Matrix5d damped = normal.information;
    damped.diagonal() *= 1 + damping;
    const Vector5d step = damped.ldlt().solve(normal.gradient);
    if (!step.allFinite()) return;
    const RelativePose candidate = moved(pose, step);
    if (cost_of(matches, members, candidate, limit) <= normal.cost) {
      pose = candidate;
      damping = std::max(1e-9, damping / 10);
      // A hundredth of a standard deviation: noise decides the rest.
      if (iteration > 1 && step.dot(normal.information * step) < 1e-4) return;
    } else {
      damping *= 10;
      if (damping > 1e6) return;
    }
  }
}

void drop_behind(std::span<const Correspondence> matches, const RelativePose& pose,
                 std::vector<Member>& members) {
  const EpipolarGeometry geometry(pose);
  std::erase_if(members, [&](const Member& m) {
    return geometry.depth_sign(matches[m.match]) == DepthSign::kBehind;
  });
}

// False when the information is singular.
bool bound_leverage(std::span<const Correspondence> matches, const RelativePose& pose, double limit,
                    std::vector<Member>& members) {
  const Eigen::LLT<Matrix5d> factor(linearize(matches, members, pose, limit).information);
  if (factor.info() != Eigen::Success) return false;
  const EpipolarGeometry geometry(pose);
  std::vector<double> leverages(members.size()), of_near;
  RowVector5d jacobian;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const double residual = geometry.residual(matches[members[k].match], &jacobian);
    leverages[k] = factor.matrixL().solve(jacobian.transpose()).squaredNorm();
    if (std::abs(residual) < limit) of_near.push_back(leverages[k]);
  }
  const double usual = take_median(of_near);
  for (std::size_t k = 0; k < members.size(); ++k)
    members[k].trust = std::min(1.0, kMaxLeverage * usual / leverages[k]);
  return true;
}

// (H' M^-1 H)^-1 with M the information as measured and H = M - N the part of it that is not noise:
// the noise N of the Jacobians enters the gradient, but does not hold the pose in place.
bool set_covariance(std::span<const Correspondence> matches, const std::vector<Member>& members,
                    double spread, RelativePose& pose) {
  const double limit = kBisquare * spread;
  const Eigen::LLT<Matrix5d> measured(linearize(matches, members, pose, limit).information);
  if (measured.info() != Eigen::Success || !(measured.rcond() > 1e-12)) return false;
  Matrix5d noise = Matrix5d::Zero();
  const EpipolarGeometry geometry(pose);
  for (const Member& m : members) {
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

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> of_direction(
      pose.covariance.bottomRightCorner<2, 2>(), Eigen::EigenvaluesOnly);
  pose.sigma_direction = std::sqrt(of_direction.eigenvalues().maxCoeff());
  return std::isfinite(pose.sigma_direction);
}

}  // namespace

bool refine_relative_pose(std::span<const Correspondence> matches, RelativePose& pose,
                          std::vector<std::uint8_t>& inlier) {
  if (inlier.empty()) inlier.assign(matches.size(), 1);
  std::vector<Member> allowed;
  for (std::size_t k = 0; k < matches.size(); ++k)
    if (inlier[k]) allowed.push_back({k});
  std::fill(inlier.begin(), inlier.end(), 0);
  if (allowed.size() < kMinInliers) return false;

  double spread = kMaxSpread;
  minimize(matches, allowed, pose, spread);
  // Wrong matches on the epipolar line show by a point behind the cameras, or by leverage. Both are
  // judged anew from the better pose.
  std::vector<Member> members;
  for (int round = 0; round < kRounds; ++round) {
    members = allowed;
    drop_behind(matches, pose, members);
    if (!bound_leverage(matches, pose, kBisquare * spread, members)) return false;
    minimize(matches, members, pose, spread);
  }
  drop_behind(matches, pose, members);

  const EpipolarGeometry geometry(pose);
  const double limit = kInlierSigma * std::max(1.0, spread);
  std::erase_if(members, [&](const Member& m) {
    return !(std::abs(geometry.residual(matches[m.match])) < limit);
  });
  for (const Member& m : members) inlier[m.match] = 1;
  return members.size() >= kMinInliers && bound_leverage(matches, pose, limit, members) &&
         set_covariance(matches, members, spread, pose);
}

}  // namespace eifmap
