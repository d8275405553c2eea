#include "motion/absolute_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// The spread of the whitened errors is 1 if the sigmas are right; estimates beyond these come from
// outliers, or from too few points.
constexpr double kMinSpread = 0.5, kMaxSpread = 2.5;
// From a guess that is far off the spread starts as wide as the errors are and narrows by this
// factor a step, so that the guess need not be within noise of the solution.
constexpr double kNarrowing = 0.6;

struct Normal {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

// Norm of the whitened error; infinite behind the camera.
double error_of(const Projector& camera, const MapObservation& o) {
  Eigen::Vector2d x;
  if (!camera(o.point, x)) return std::numeric_limits<double>::infinity();
  return (o.x - x).norm() / o.sigma;
}

std::vector<double> errors_of(const Rigid3& pose, std::span<const MapObservation> observations) {
  const Projector camera(pose);
  std::vector<double> errors;
  errors.reserve(observations.size());
  for (const MapObservation& o : observations) errors.push_back(error_of(camera, o));
  return errors;
}

double cost_of(const std::vector<double>& errors, double limit) {
  double cost = 0;
  for (double error : errors)
    cost += error < limit ? bisquare_cost(error, limit) : limit * limit / 6;
  return cost;
}

// Of the errors below `limit`; not clamped.
double spread_of(const std::vector<double>& errors, double limit) {
  std::vector<double> sizes;
  sizes.reserve(errors.size());
  for (double error : errors)
    if (error < limit) sizes.push_back(error);
  return kSpreadFromMedian2d * take_median(sizes);
}

Normal linearize(const Rigid3& pose, std::span<const MapObservation> observations,
                 const std::vector<double>& errors, double limit) {
  const Projector camera(pose);
  Normal normal;
  Eigen::Vector2d x;
  Eigen::Matrix<double, 2, 6> jacobian;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if (!(errors[k] < limit)) continue;
    const MapObservation& o = observations[k];
    if (!camera(o.point, x, &jacobian)) continue;
    const double weight = bisquare_weight(errors[k], limit) / (o.sigma * o.sigma);
    normal.information.noalias() += weight * jacobian.transpose() * jacobian;
    normal.gradient.noalias() += weight * jacobian.transpose() * (o.x - x);
  }
  return normal;
}

// Levenberg-Marquardt with bisquare weights. Returns the spread.
double minimize(std::span<const MapObservation> observations, const AbsolutePoseOptions& options,
                Rigid3& pose) {
  std::vector<double> errors = errors_of(pose, observations);
  double widest = std::max(kMaxSpread, spread_of(errors, std::numeric_limits<double>::infinity()));
  double spread = widest, damping = 1e-6;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const double limit = options.bisquare * spread;
    const Normal normal = linearize(pose, observations, errors, limit);
    Matrix6d damped = normal.information;
    damped.diagonal() *= 1 + damping;
    const Vector6d step = damped.ldlt().solve(normal.gradient);
    if (!step.allFinite()) break;
    const Rigid3 candidate = retract(pose, step.head<3>(), step.tail<3>());
    std::vector<double> moved = errors_of(candidate, observations);
    if (cost_of(moved, limit) <= cost_of(errors, limit)) {
      pose = candidate;
      errors = std::move(moved);
      damping = std::max(1e-9, damping / 10);
      // A hundredth of a standard deviation: noise decides the rest.
      if (widest == kMaxSpread && step.dot(normal.information * step) < 1e-4) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
    widest = std::max(kMaxSpread, kNarrowing * widest);
    spread = std::clamp(spread_of(errors, limit), kMinSpread, widest);
  }
  return std::min(spread, kMaxSpread);
}

// Inliers and covariance of result.world_from_camera; `spread` of the errors.
void judge(std::span<const MapObservation> observations, const AbsolutePoseOptions& options,
           double spread, double gate, AbsolutePose& result) {
  const std::vector<double> errors = errors_of(result.world_from_camera, observations);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    result.inlier[k] = errors[k] < gate;
    result.num_inliers += result.inlier[k];
  }
  if (result.num_inliers < options.min_inliers) return;

  const Normal normal = linearize(result.world_from_camera, observations, errors,
                                  options.bisquare * std::max(1.0, spread));
  const Eigen::LLT<Matrix6d> factor(normal.information);
  if (factor.info() != Eigen::Success || !(factor.rcond() > 1e-14)) return;
  result.covariance = std::max(1.0, spread * spread) * factor.solve(Matrix6d::Identity());
  result.reason = Reason::kNone;
}

AbsolutePose unjudged(const Rigid3& pose, std::span<const MapObservation> observations,
                      const AbsolutePoseOptions& options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  AbsolutePose result;
  result.world_from_camera = pose;
  result.inlier.assign(observations.size(), 0);
  return result;
}

}  // namespace

std::string AbsolutePoseOptions::problem() const {
  if (min_inliers < 4) return "absolute_pose.min_inliers must be at least 4";
  if (!(gate_sigma > 0)) return "absolute_pose.gate_sigma must be above 0";
  if (max_iterations < 1) return "absolute_pose.max_iterations must be at least 1";
  if (!(bisquare >= 1)) return "absolute_pose.bisquare must be at least 1";
  if (!(ransac_threshold_px > 0)) return "absolute_pose.ransac_threshold_px must be above 0";
  if (!(ransac_confidence > 0 && ransac_confidence < 1))
    return "absolute_pose.ransac_confidence must be in (0, 1)";
  if (ransac_iterations < 1) return "absolute_pose.ransac_iterations must be at least 1";
  if (seed < 0) return "absolute_pose.seed must be >= 0";
  return "";
}

AbsolutePose refine_absolute_pose(const Rigid3& world_from_guess,
                                  std::span<const MapObservation> observations,
                                  const AbsolutePoseOptions& options) {
  AbsolutePose result = unjudged(world_from_guess, observations, options);
  if (static_cast<int>(observations.size()) < options.min_inliers) return result;
  const double spread = minimize(observations, options, result.world_from_camera);
  judge(observations, options, spread, options.gate_sigma, result);
  return result;
}

AbsolutePose judge_absolute_pose(const Rigid3& world_from_camera,
                                 std::span<const MapObservation> observations,
                                 const AbsolutePoseOptions& options) {
  AbsolutePose result = unjudged(world_from_camera, observations, options);
  if (static_cast<int>(observations.size()) < options.min_inliers) return result;
  // The errors include the pose's own, which nothing has taken out.
  const double spread = std::clamp(
      spread_of(errors_of(world_from_camera, observations), options.bisquare * kMaxSpread), 1.0,
      kMaxSpread);
  judge(observations, options, spread, options.gate_sigma * spread, result);
  return result;
}

}  // namespace eifmap
