#include "map/frame_covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

// A sight in the pose's normal equations: step = N^-1 sum J' w (z - h).
struct Sensed {
  int landmark = 0;  // in the filter
  Eigen::Matrix<double, 2, 6> d_pose;
  Eigen::Matrix<double, 2, 3> d_point;
  Eigen::Matrix2d noise;  // of z - h, given the keyframes
  double error = 0;       // norm of the whitened residual
  double weight = 0;
};

bool sense(const Map& map, const ObservedFrame& observed, const LandmarkSight& sight,
           const Projector& projector, Sensed& sensed) {
  Eigen::Vector2d x;
  if (!projector(map.position(sight.track), x, &sensed.d_pose, &sensed.d_point)) return false;
  sensed.landmark = map.track(sight.track).landmark;
  const double sigma = observed.sigma[sight.keypoint];
  sensed.noise = sensed.d_point * map.position_covariance(sight.track) * sensed.d_point.transpose();
  // The weight is that of the fit, which takes one sigma for both axes.
  const double variance = sigma * sigma + sensed.noise.trace();
  sensed.noise.diagonal().array() += sigma * sigma;
  sensed.error = (observed.x[sight.keypoint] - x).norm() / std::sqrt(variance);
  sensed.weight = 1 / variance;
  return true;
}

// Multiplies in the bisquare weights of the fit; returns the residuals' spread, at least 1.
double weigh(std::vector<Sensed>& all, const AbsolutePoseOptions& options) {
  std::vector<double> sizes;
  for (const Sensed& s : all) sizes.push_back(s.error);
  const double spread = std::max(1.0, kSpreadFromMedian2d * take_median(sizes));
  for (Sensed& s : all) s.weight *= bisquare_weight(s.error, options.bisquare * spread);
  return spread;
}

}  // namespace

bool frame_error(const Map& map, const ObservedFrame& observed, const Tracking& tracking,
                 const AbsolutePoseOptions& options, FrameError& error) {
  const Projector projector(tracking.world_from_camera);
  std::vector<Sensed> all;
  for (const LandmarkSight& sight : tracking.sights) {
    Sensed sensed;
    if (sense(map, observed, sight, projector, sensed)) all.push_back(sensed);
  }
  const double spread = weigh(all, options);
  PoseBlock normal = PoseBlock::Zero(), noise = PoseBlock::Zero();
  for (const Sensed& s : all) {
    const Eigen::Matrix<double, 6, 2> pull = s.weight * s.d_pose.transpose();
    normal.noalias() += pull * s.d_pose;
    noise.noalias() += pull * s.noise * pull.transpose();
  }
  const Eigen::LLT<PoseBlock> factor(normal);
  if (factor.info() != Eigen::Success || !(factor.rcond() > 1e-14)) return false;
  const PoseBlock inverse = factor.solve(PoseBlock::Identity());

  // d step / d keyframe = N^-1 sum J' w H_f V^-1 W', by keyframe.
  std::vector<PoseSensitivity> sensitivities(static_cast<std::size_t>(map.num_keyframes()));
  for (const Sensed& s : all) {
    const FilterLandmark& landmark = map.filter().landmark(s.landmark);
    const Eigen::Matrix<double, 6, 3> through =
        s.weight * inverse * s.d_pose.transpose() * s.d_point * landmark.covariance;
    for (const PointMeasurement& m : landmark.measurements)
      sensitivities[static_cast<std::size_t>(m.pose)].derivative.noalias() +=
          through * (m.frozen.to_landmark.transpose() * m.d_pose());
  }
  for (int k = 0; k < map.num_keyframes(); ++k) sensitivities[static_cast<std::size_t>(k)].pose = k;
  std::erase_if(sensitivities, [](const PoseSensitivity& s) { return s.derivative.isZero(0); });
  error.own = spread * spread * inverse * noise * inverse;
  error.from_keyframes = std::move(sensitivities);
  return true;
}

bool frame_covariance(const Map& map, const ObservedFrame& observed, const Tracking& tracking,
                      const AbsolutePoseOptions& options, PoseBlock& covariance) {
  FrameError error;
  if (!frame_error(map, observed, tracking, options, error)) return false;
  PoseBlock from_keyframes;
  if (!map.filter().propagate(error.from_keyframes, from_keyframes)) return false;
  covariance = error.own + from_keyframes;
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  return covariance.allFinite();
}

}  // namespace eifmap
