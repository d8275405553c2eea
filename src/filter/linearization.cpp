#include "filter/linearization.h"

#include <cmath>
#include <limits>
#include <utility>

namespace eifmap {
namespace {

// Of an edge (5 degrees of freedom): about 1 in 7 is beyond it by chance.
constexpr double kEdgeLimit = 3.0;

// Huber's weight: full to k sigmas, then falling as k / error. The weight is part of the
// measurement's noise, Q, and is frozen with its Jacobian.
double robust_weight(double error, double k) {
  return error <= k ? 1 : k / error;
}

}  // namespace

bool linearize(PointMeasurement& m, const Projector& projector, const Eigen::Vector3d& point,
               const Holding& holding, double huber_sigma) {
  const double depth = projector.depth(point);
  Eigen::Vector2d predicted;
  Eigen::Matrix<double, 2, 3> to_point;
  if (!projector(point, predicted, nullptr, &to_point)) {
    m.frozen = m.now = {};
    m.scale = 0;
    m.residual.setZero();
    return std::exchange(m.linearized, false);
  }
  // Times the depth, nothing is left of the derivative to the place but prediction and rotation.
  const auto turned = [&] {
    const double frozen = m.depth * m.sigma / m.root;
    return (depth * to_point - frozen * m.frozen.to_landmark).squaredNorm();
  };
  const bool holds = m.linearized &&
                     (predicted - m.frozen.at).squaredNorm() <= holding.within * holding.within &&
                     std::abs(depth - m.depth) <= holding.of_depth * m.depth &&
                     turned() <= holding.turned * holding.turned;
  const Eigen::Vector2d residual = (m.x - predicted) / m.sigma;
  if (!holds) {
    m.root = std::sqrt(robust_weight(residual.norm(), huber_sigma));
    m.scale = m.root / m.sigma;
  }
  m.now.at = predicted;
  m.now.to_landmark = m.scale * to_point;
  m.residual = m.root * residual;
  if (holds) return false;
  m.frozen = m.now;
  m.depth = depth;
  return m.linearized = true;
}

void linearize(FilterEdge& edge, const Rigid3& world_from_i, const Rigid3& world_from_j,
               Relinearize when, double variance) {
  constexpr double kMoved = 0.02;   // sigmas
  constexpr double kTurned = 1e-3;  // of the derivative
  if (edge.linearized && !edge.moved && !edge.changed) return;
  RelativePoseLinearization at_mean;
  const bool defined = linearize(edge.measurement, world_from_i, world_from_j, at_mean);
  edge.squared_error =
      defined ? at_mean.residual.squaredNorm() : std::numeric_limits<double>::infinity();
  if (edge.linearized && when == Relinearize::kOnce) return;
  const bool holds =
      edge.linearized && defined && !edge.changed && when == Relinearize::kThreshold &&
      (at_mean.residual - edge.residual_then).norm() <= kMoved &&
      (edge.root * at_mean.d_j - edge.frozen.d_j).norm() <= kTurned * edge.frozen.d_j.norm();
  if (!holds) {
    const double error = std::sqrt(edge.squared_error / variance);
    edge.root = defined ? std::sqrt(robust_weight(error, kEdgeLimit) / variance) : 0;
    edge.residual_then = at_mean.residual;
  }
  edge.now.residual = edge.root * at_mean.residual;
  edge.now.d_i = edge.root * at_mean.d_i;
  edge.now.d_j = edge.root * at_mean.d_j;
  if (holds) return;
  edge.frozen = edge.now;
  edge.linearized = defined;
  edge.changed = true;
}

void linearize(FilterAbsolute& absolute, AbsoluteRows at_mean, Relinearize when, double weight) {
  constexpr double kTurned = 1e-3;  // of the derivative
  absolute.squared_error = (absolute.whiten * at_mean.residual).squaredNorm();
  if (absolute.linearized && when == Relinearize::kOnce) return;
  const Eigen::Matrix3d scale = std::sqrt(weight) * absolute.whiten;
  at_mean.residual = scale * at_mean.residual;
  for (PoseRows& rows : at_mean.of_pose) rows.derivative = scale * rows.derivative;
  absolute.now = std::move(at_mean);
  const auto turned = [&absolute] {
    double sum = 0;
    for (std::size_t k = 0; k < absolute.now.of_pose.size(); ++k)
      sum += (absolute.now.of_pose[k].derivative - absolute.frozen.of_pose[k].derivative)
                 .squaredNorm();
    return sum;
  };
  if (absolute.linearized && !absolute.changed && when == Relinearize::kThreshold &&
      turned() <= kTurned * kTurned * absolute.frozen.squared_derivative())
    return;
  absolute.frozen = absolute.now;
  absolute.linearized = true;
  absolute.changed = true;
}

}  // namespace eifmap
