#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/rigid3.h"
#include "motion/epipolar.h"
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

// A pose prepared for many matches.
struct Epipolar {
  explicit Epipolar(const RelativePose& pose)
      : r(pose.i_from_j.toRotationMatrix()), t(pose.direction), basis(sphere_basis(t)) {}
  Eigen::Matrix3d r;
  Eigen::Vector3d t;
  Eigen::Matrix<double, 3, 2> basis;
};

double whitened_sampson(const Correspondence& match, const Epipolar& e, RowVector5d* jacobian) {
  const Eigen::Vector3d x_i = match.x_i.homogeneous(), x_j = match.x_j.homogeneous();
  const Eigen::Vector3d y = e.r * x_j;
  const Eigen::Vector3d line_i = e.t.cross(y);                      // E x_j
  const Eigen::Vector3d line_j = e.r.transpose() * x_i.cross(e.t);  // E' x_i
  const double si2 = match.sigma_i * match.sigma_i, sj2 = match.sigma_j * match.sigma_j;
  // First-order variance of the algebraic residual x_i' E x_j.
  const double variance =
      si2 * line_i.head<2>().squaredNorm() + sj2 * line_j.head<2>().squaredNorm();
  if (!(variance > 0)) {
    if (jacobian) jacobian->setZero();
    return 0;  // both points on the epipoles: the match says nothing
  }
  const double algebraic = x_i.dot(line_i);
  const double inverse_sigma = 1 / std::sqrt(variance);
  if (jacobian) {
    // With R <- R Exp(w): y moves by R (w x x_j), E' x_i by line_j x w; t moves by basis ab.
    // Derivatives of the weighted lines, contracted: k = variance gradient / 2 on each side.
    const Eigen::Vector3d k_i(si2 * line_i.x(), si2 * line_i.y(), 0);
    const Eigen::Vector3d k_j(sj2 * line_j.x(), sj2 * line_j.y(), 0);
    const double half = algebraic / variance;
    // d(algebraic) - half d(variance)/... : both are linear in the lines' changes.
    const Eigen::Vector3d on_line_i = x_i - half * k_i;
    const Eigen::Vector3d on_y = on_line_i.cross(e.t);
    const Eigen::Vector3d on_t = y.cross(on_line_i) - half * (e.r * k_j).cross(x_i);
    jacobian->head<3>() =
        (x_j.cross(e.r.transpose() * on_y) - half * k_j.cross(line_j)).transpose();
    jacobian->tail<2>() = on_t.transpose() * e.basis;
    *jacobian *= inverse_sigma;
  }
  return algebraic * inverse_sigma;
}

struct Normal {
  Matrix5d information = Matrix5d::Zero();
  Vector5d gradient = Vector5d::Zero();
};

// Weighted normal equations; `spread` is measured on the way (of residuals below the limit).
Normal linearize(std::span<const Correspondence> matches, const std::vector<std::size_t>& active,
                 const RelativePose& pose, double limit) {
  const Epipolar epipolar(pose);
  Normal normal;
  RowVector5d jacobian;
  for (std::size_t k : active) {
    const double residual = whitened_sampson(matches[k], epipolar, &jacobian);
    const double weight = bisquare_weight(residual, limit);
    if (weight == 0) continue;
    normal.information.noalias() += weight * jacobian.transpose() * jacobian;
    normal.gradient.noalias() -= weight * residual * jacobian.transpose();
  }
  return normal;
}

double cost_of(std::span<const Correspondence> matches, const std::vector<std::size_t>& active,
               const RelativePose& pose, double limit) {
  const Epipolar epipolar(pose);
  double cost = 0;
  for (std::size_t k : active)
    cost += bisquare_cost(whitened_sampson(matches[k], epipolar, nullptr), limit);
  return cost;
}

// Of the residuals below `limit`, clamped.
double spread_of(std::span<const Correspondence> matches, const std::vector<std::size_t>& active,
                 const RelativePose& pose, double limit) {
  const Epipolar epipolar(pose);
  std::vector<double> sizes;
  sizes.reserve(active.size());
  for (std::size_t k : active) {
    const double size = std::abs(whitened_sampson(matches[k], epipolar, nullptr));
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

// Levenberg-Marquardt; the spread follows the residuals in the first steps, then stands still so
// that the cost has a minimum to settle in. Returns the spread.
double minimize(std::span<const Correspondence> matches, const std::vector<std::size_t>& active,
                RelativePose& pose) {
  constexpr int kSpreadSteps = 6, kSteps = 25;
  double spread = kMaxSpread, damping = 1e-4;
  for (int iteration = 0; iteration < kSteps; ++iteration) {
    if (iteration < kSpreadSteps) spread = spread_of(matches, active, pose, kBisquare * spread);
    const double limit = kBisquare * spread;
    const Normal normal = linearize(matches, active, pose, limit);
    Matrix5d damped = normal.information;
    damped.diagonal() *= 1 + damping;
    const Vector5d step = damped.ldlt().solve(normal.gradient);
    if (!step.allFinite()) break;
    const RelativePose candidate = moved(pose, step);
    if (cost_of(matches, active, candidate, limit) <= cost_of(matches, active, pose, limit)) {
      pose = candidate;
      damping = std::max(1e-9, damping / 10);
      // A hundredth of a standard deviation: noise decides the rest.
      if (iteration >= kSpreadSteps && step.dot(normal.information * step) < 1e-4) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  return spread;
}

// Linear, from the agreeing matches; never better than their own scatter.
bool set_covariance(std::span<const Correspondence> matches,
                    const std::vector<std::size_t>& agreeing, double spread, RelativePose& pose) {
  const Normal normal = linearize(matches, agreeing, pose, kBisquare * spread);
  const Eigen::LLT<Matrix5d> factor(normal.information);
  if (factor.info() != Eigen::Success || !(factor.rcond() > 1e-12)) return false;
  const double scale = std::max(1.0, spread * spread);
  pose.covariance = scale * factor.solve(Matrix5d::Identity());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      pose.covariance.bottomRightCorner<2, 2>(), Eigen::EigenvaluesOnly);
  pose.sigma_direction = std::sqrt(solver.eigenvalues().maxCoeff());
  return std::isfinite(pose.sigma_direction);
}

}  // namespace

double sampson_residual(const Correspondence& match, const RelativePose& pose,
                        RowVector5d* jacobian) {
  return whitened_sampson(match, Epipolar(pose), jacobian);
}

bool refine_relative_pose(std::span<const Correspondence> matches, double /*radians_per_pixel*/,
                          RelativePose& pose, std::vector<std::uint8_t>& inlier) {
  if (inlier.empty()) inlier.assign(matches.size(), 1);
  std::vector<std::size_t> active;
  for (std::size_t k = 0; k < matches.size(); ++k)
    if (inlier[k]) active.push_back(k);

  std::fill(inlier.begin(), inlier.end(), 0);
  if (active.size() < kMinInliers) return false;
  double spread = minimize(matches, active, pose);
  // Wrong matches on the epipolar line show by a point behind the cameras.
  const Eigen::Matrix3d r = pose.i_from_j.toRotationMatrix();
  const auto behind = [&](std::size_t k) {
    return depth_sign(matches[k], r, pose.direction) == DepthSign::kBehind;
  };
  if (std::erase_if(active, behind) > 0 && active.size() >= kMinInliers)
    spread = minimize(matches, active, pose);

  const Epipolar epipolar(pose);
  std::vector<std::size_t> agreeing;
  for (std::size_t k : active) {
    const double limit = kInlierSigma * std::max(1.0, spread);
    if (std::abs(whitened_sampson(matches[k], epipolar, nullptr)) < limit) agreeing.push_back(k);
  }
  for (std::size_t k : agreeing) inlier[k] = 1;
  return agreeing.size() >= kMinInliers && set_covariance(matches, agreeing, spread, pose);
}

}  // namespace eifmap
