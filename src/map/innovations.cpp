#include "map/innovations.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "geometry/projection.h"

namespace eifmap {

NisSum innovations_of_sights(const Map& map, const ObservedFrame& observed,
                             const Tracking& tracking) {
  constexpr double kPoseDegrees = 6;
  const Projector projector(tracking.world_from_camera);
  NisSum sum;
  sum.fitted = kPoseDegrees;
  for (const LandmarkSight& sight : tracking.sights) {
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 3> d_point;
    if (!projector(map.position(sight.track), predicted, nullptr, &d_point)) continue;
    const double sigma = observed.sigma.at(sight.keypoint);
    Eigen::Matrix2d noise = d_point * map.position_covariance(sight.track) * d_point.transpose();
    noise.diagonal().array() += sigma * sigma;
    const Eigen::Vector2d residual = observed.x[sight.keypoint] - predicted;
    const double squared = residual.dot(noise.llt().solve(residual));
    if (!(squared < kSightNisGate * kSightNisGate)) {
      ++sum.beyond;
      continue;
    }
    sum.squared += squared;
    ++sum.count;
  }
  return sum;
}

std::optional<double> squared_innovation(const Map& map, const FilterEdge& edge,
                                         const FrameError& error, double variance) {
  RelativePoseLinearization at_mean;
  if (!linearize(edge.measurement, map.pose(edge.i), map.pose(edge.j), at_mean))
    return std::nullopt;
  std::vector<PoseSensitivity> sensitivities = error.from_keyframes;
  for (PoseSensitivity& s : sensitivities) {
    const PoseBlock of_frame = s.derivative;
    s.derivative.setZero();
    s.derivative.topRows<5>() = at_mean.d_j * of_frame;
  }
  sensitivities.push_back({edge.i, PoseBlock::Zero()});
  sensitivities.back().derivative.topRows<5>() = at_mean.d_i;
  PoseBlock propagated;
  if (!map.filter().propagate(sensitivities, propagated)) return std::nullopt;
  // Residual and derivatives are whitened by R.
  Eigen::Matrix<double, 5, 5> innovation = propagated.topLeftCorner<5, 5>();
  innovation.noalias() += at_mean.d_j * error.own * at_mean.d_j.transpose();
  innovation.diagonal().array() += variance;
  const Eigen::LLT<Eigen::Matrix<double, 5, 5>> factor(innovation);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return at_mean.residual.dot(factor.solve(at_mean.residual));
}

}  // namespace eifmap
