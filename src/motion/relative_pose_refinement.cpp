#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/rigid3.h"
#include "geometry/robust.h"
#include "motion/epipolar_fit.h"
#include "motion/epipolar_geometry.h"

namespace eifmap {
namespace {

constexpr std::size_t kMinInliers = 8;
constexpr double kInlierSigma = 3.0;  // of a whitened Sampson residual
// The spread of the whitened residuals is 1 if the sigmas are right; estimates beyond these come
// from outliers, or from too few points.
constexpr double kMinSpread = 0.5, kMaxSpread = 2.5;
// A match moves the pose by its leverage. Wrong matches that happen to lie near their epipolar
// lines have random, mostly huge parallax: a handful of them at 40 % outliers doubled the
// direction's error. Above this many times the median, leverage is cut (C. Mallows' weights).
constexpr double kMaxLeverage = 4;
constexpr int kRounds = 2;

using Members = std::vector<EpipolarMember>;

double cost_of(std::span<const Correspondence> matches, const Members& members,
               const RelativePose& pose, double limit) {
  const EpipolarGeometry geometry(pose);
  double cost = 0;
  for (const EpipolarMember& m : members)
    cost += m.trust * bisquare_cost(geometry.residual(matches[m.match]), limit);
  return cost;
}

// Of the residuals below `limit`, clamped.
double spread_of(std::span<const Correspondence> matches, const Members& members,
                 const RelativePose& pose, double limit) {
  const EpipolarGeometry geometry(pose);
  std::vector<double> sizes;
  sizes.reserve(members.size());
  for (const EpipolarMember& m : members) {
    const double size = std::abs(geometry.residual(matches[m.match]));
    if (size < limit) sizes.push_back(size);
  }
  return std::clamp(kSpreadFromMedian1d * take_median(sizes), kMinSpread, kMaxSpread);
}

// Levenberg-Marquardt from `spread` on; the spread follows the residuals in the first steps, then
// stands still so that the cost has a minimum to settle in.
void minimize(std::span<const Correspondence> matches, const Members& members, RelativePose& pose,
              double& spread) {
  constexpr int kSpreadSteps = 5, kSteps = 25;
  double damping = 1e-4;
  for (int iteration = 0; iteration < kSteps; ++iteration) {
    if (iteration < kSpreadSteps) spread = spread_of(matches, members, pose, kBisquare * spread);
    const double limit = kBisquare * spread;
    const EpipolarNormal normal = linearize(matches, members, pose, limit);
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
                 Members& members) {
  const EpipolarGeometry geometry(pose);
  std::erase_if(members, [&](const EpipolarMember& m) {
    return geometry.depth_sign(matches[m.match]) == DepthSign::kBehind;
  });
}

// False when the information is singular.
bool bound_leverage(std::span<const Correspondence> matches, const RelativePose& pose, double limit,
                    Members& members) {
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

}  // namespace

bool refine_relative_pose(std::span<const Correspondence> matches, RelativePose& pose,
                          std::vector<std::uint8_t>& inlier, RelativePoseCovariance covariance) {
  if (inlier.empty()) inlier.assign(matches.size(), 1);
  Members allowed;
  for (std::size_t k = 0; k < matches.size(); ++k)
    if (inlier[k]) allowed.push_back({k});
  std::fill(inlier.begin(), inlier.end(), 0);
  if (allowed.size() < kMinInliers) return false;

  double spread = kMaxSpread;
  minimize(matches, allowed, pose, spread);
  // Wrong matches on the epipolar line show by a point behind the cameras, or by leverage. Both are
  // judged anew from the better pose.
  Members members;
  for (int round = 0; round < kRounds; ++round) {
    members = allowed;
    drop_behind(matches, pose, members);
    if (!bound_leverage(matches, pose, kBisquare * spread, members)) return false;
    minimize(matches, members, pose, spread);
  }
  drop_behind(matches, pose, members);

  const EpipolarGeometry geometry(pose);
  const double limit = kInlierSigma * std::max(1.0, spread);
  std::erase_if(members, [&](const EpipolarMember& m) {
    return !(std::abs(geometry.residual(matches[m.match])) < limit);
  });
  for (const EpipolarMember& m : members) inlier[m.match] = 1;
  if (members.size() < kMinInliers || !bound_leverage(matches, pose, limit, members)) return false;
  return covariance == RelativePoseCovariance::kUnscented
             ? set_unscented_covariance(matches, members, spread, pose)
             : set_linear_covariance(matches, members, spread, pose);
}

}  // namespace eifmap
