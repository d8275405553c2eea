// How absolute measurements enter the filter, and what they say of the map's scale.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "filter/derived_covariances.h"
#include "filter/information_filter.h"
#include "filter/landmark_distance.h"
#include "geometry/robust.h"
#include "geometry/similarity.h"

namespace eifmap {
namespace {

// Chi-square by degrees of freedom, from 1: 1 in 10,000, beyond which a measurement contradicts the
// map; the median; and what 1 in 10 is beyond.
constexpr std::array<double, 4> kGate = {0, 15.1, 18.4, 21.1};
constexpr std::array<double, 4> kMedian = {0, 0.455, 1.386, 2.366};
constexpr std::array<double, 4> kTenth = {0, 2.706, 4.605, 6.251};

// A map that was right so far may no longer be: so many innovations are judged together, as if one
// more had been as large as it should. And the most that a map may be worse than it says.
constexpr std::size_t kLatest = 8;
constexpr double kLargestVariance = 400;

// Of n innovations as large as they should be, this many or more are beyond what 1 in 10 is beyond
// in 2 of 1,000 cases at most. So the map contradicts them. Their median alone would not do: where
// measurements are noisier than the map, it asks for any variance, now a large one and now a small
// one, and of those the largest stayed.
constexpr std::array<int, kLatest + 1> kContradicting = {9, 9, 9, 3, 4, 4, 4, 5, 5};

struct Innovation {
  Eigen::VectorXd value;
  Eigen::MatrixXd of_map, of_measurement;  // covariances

  double squared(double variance) const {  // sigmas
    return value.dot((variance * of_map + of_measurement).ldlt().solve(value));
  }
  // The variance of the map with which this innovation is so large, within bounds.
  double variance_asked_for(double chi_square) const {
    double low = std::log(0.01), high = std::log(1e4);
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (low + high);
      (squared(std::exp(middle)) > chi_square ? low : high) = middle;
    }
    return std::exp(low);
  }
};

}  // namespace

void InformationFilter::make_metric(double metres_per_unit) {
  if (!has_gauge_ || is_metric_ || !(metres_per_unit > 0) || !std::isfinite(metres_per_unit))
    throw std::invalid_argument("InformationFilter::make_metric: no gauge, or not so");
  const auto scaled = [metres_per_unit](const Rigid3& pose) {
    return Rigid3(pose.rotation, metres_per_unit * pose.translation);
  };
  for (int p = 0; p < num_poses(); ++p) set_pose(p, scaled(poses_[p]));
  for (Rigid3& pose : poses_before_) pose = scaled(pose);
  for (int l = 0; l < num_landmarks(); ++l) {
    if (landmarks_[l].is_removed()) continue;
    FilterLandmark& landmark = landmarks_.write(l);
    landmark.position *= metres_per_unit;
    landmark.covariance *= metres_per_unit * metres_per_unit;
  }
  for (auto& [landmark, position] : positions_before_) position *= metres_per_unit;
  earth_from_map_.translation *= metres_per_unit;
  gauge_.length = 0;
  system_.set_gauge(gauge_);
  is_metric_ = true;
  linearize_all_anew();
}

void InformationFilter::set_earth_from_map(const Rigid3& earth_from_map) {
  if (!is_metric_)
    throw std::invalid_argument("InformationFilter: earth_from_map of a map without scale");
  if (!has_level()) system_.append_earth(num_poses());
  system_.release_earth();
  is_placed_ = true;
  earth_from_map_ = earth_from_map;
  for (FilterAbsolute& absolute : absolutes_) absolute.linearized = false, absolute.changed = true;
}

void InformationFilter::set_level(const Eigen::Quaterniond& earth_from_map) {
  if (has_level() || num_poses() < 2)
    throw std::invalid_argument(
        "InformationFilter: a level of a map that has one, or no two poses");
  system_.append_earth(num_poses());
  earth_from_map_ = {earth_from_map, Eigen::Vector3d::Zero()};
  system_.hold_earth(earth_from_map_.matrix().row(2).transpose());
}

Reason InformationFilter::add_absolute(const AbsoluteObservation& observation, bool gated,
                                       bool again) {
  using Kind = AbsoluteObservation::Kind;
  if (!is_metric_ && observation.kind != Kind::kDown)
    throw std::invalid_argument("InformationFilter: the map has no scale yet");
  if (const Reason reason = check(observation); reason != Reason::kNone) return reason;
  FilterAbsolute absolute;
  absolute.observation = observation;
  if (!whitening(observation, absolute.whiten)) return Reason::kBadMeasurementCovariance;
  if (observation.is_length() && !has_baseline(observation))
    return Reason::kMeasurementWithoutBaseline;
  if (gated) {
    for (const RigidPoint& point : observation.points)
      if (!knows(point.pose)) return Reason::kMeasurementWithoutPose;
    if (observation.kind == Kind::kLandmarks && !knows_landmarks(observation))
      return Reason::kMeasurementWithoutLandmark;
    const Rigid3 before = earth_from_map_;
    if (observation.kind == Kind::kPosition) find_earth_again(observation);
    if (!passes_gate(absolute, again)) {
      if (has_earth()) set_earth_from_map(before);
      return Reason::kMeasurementGated;
    }
  }
  absolutes_.push_back(std::move(absolute));
  if (observation.kind == Kind::kLandmarks)
    // The others that theirs count for count less from now on.
    for (FilterAbsolute& other : absolutes_)
      if (other.observation.kind == Kind::kLandmarks) other.changed = true;
  return Reason::kNone;
}

// By itself, but for its covariance.
Reason InformationFilter::check(const AbsoluteObservation& observation) const {
  using Kind = AbsoluteObservation::Kind;
  const std::size_t wanted = observation.kind == Kind::kLandmarks ? 0
                             : observation.kind == Kind::kLength  ? 2
                                                                  : 1;
  if (observation.points.size() < wanted) return Reason::kBadMeasurement;
  if (observation.points.size() > kMostPoints) return Reason::kMeasurementTooLong;
  for (const RigidPoint& point : observation.points) {
    if (point.pose < 0 || point.pose >= num_poses())
      throw std::invalid_argument("InformationFilter: no such pose");
    if (is_removed(point.pose)) return Reason::kMeasurementWithoutPose;
    if (!point.in_pose.allFinite()) return Reason::kBadMeasurement;
  }
  if (!observation.value.allFinite()) return Reason::kBadMeasurement;
  if (observation.kind == Kind::kPosition && !has_earth()) return Reason::kMeasurementWithoutPose;
  if (observation.kind == Kind::kDown && !has_level()) return Reason::kMeasurementWithoutPose;
  if (observation.kind != Kind::kLandmarks) return Reason::kNone;
  for (int landmark : observation.landmarks) {
    if (landmark < 0 || landmark >= num_landmarks())
      throw std::invalid_argument("InformationFilter: no such landmark");
    if (landmarks_[landmark].measurements.empty()) return Reason::kMeasurementWithoutLandmark;
  }
  return observation.landmarks[0] == observation.landmarks[1] ? Reason::kMeasurementWithoutBaseline
                                                              : Reason::kNone;
}

bool InformationFilter::knows_landmarks(const AbsoluteObservation& observation) const {
  return std::all_of(observation.landmarks.begin(), observation.landmarks.end(), [this](int l) {
    const std::vector<PointMeasurement>& sights = landmarks_[l].measurements;
    return std::all_of(sights.begin(), sights.end(),
                       [this](const PointMeasurement& m) { return knows(m.pose); });
  });
}

// What a landmark's own sights leave open is the same error in all of its distances, and so counts
// in each as often as there are such: together they never say more than they do.
AbsoluteRows InformationFilter::rows_of(const AbsoluteObservation& observation,
                                        double& of_landmarks) const {
  of_landmarks = 0;
  if (observation.kind != AbsoluteObservation::Kind::kLandmarks)
    return linearize(observation, poses_, earth_from_map_);
  const auto [a, b] = observation.landmarks;
  DistanceRows distance = linearize_distance(landmarks_[a], landmarks_[b], observation.value.x());
  of_landmarks =
      std::max(1, num_distances(a)) * distance.of_a + std::max(1, num_distances(b)) * distance.of_b;
  return std::move(distance.rows);
}

// A distance of landmarks is linearized whenever they are, and may be of other poses then.
void InformationFilter::linearize_moved(FilterAbsolute& absolute) {
  const AbsoluteObservation& observation = absolute.observation;
  const bool of_landmarks = observation.kind == AbsoluteObservation::Kind::kLandmarks;
  if (of_landmarks &&
      (touched_.contains(observation.landmarks[0]) || touched_.contains(observation.landmarks[1])))
    absolute.moved = true;
  if (absolute.stands()) return;
  double added = 0;
  AbsoluteRows rows = rows_of(observation, added);
  if (of_landmarks) {
    absolute.whiten(0, 0) = 1 / std::sqrt(observation.covariance(0, 0) + absolute_weight_ * added);
    const bool same = std::equal(
        rows.of_pose.begin(), rows.of_pose.end(), absolute.frozen.of_pose.begin(),
        absolute.frozen.of_pose.end(),
        [](const PoseRows& now, const PoseRows& frozen) { return now.pose == frozen.pose; });
    if (!same) {
      system_.before_removal(absolute);
      absolute.linearized = false, absolute.changed = true;
    }
  }
  linearize(absolute, std::move(rows), options_.relinearize, absolute_weight_);
}

// Whether it says anything of where poses are to each other.
bool InformationFilter::has_baseline(const AbsoluteObservation& observation) const {
  constexpr double kLittle = 1e-6;
  double squared = 0, of_landmarks = 0;
  for (const PoseRows& rows : rows_of(observation, of_landmarks).of_pose)
    squared += rows.derivative.rightCols<3>().squaredNorm();
  return squared > kLittle;
}

// By the innovation at the mean, whose covariance is the measurement's and that of the poses and of
// earth_from_map together.
bool InformationFilter::passes_gate(const FilterAbsolute& absolute, bool again) {
  const AbsoluteObservation& observation = absolute.observation;
  double of_landmarks = 0;
  const AbsoluteRows rows = rows_of(observation, of_landmarks);
  std::vector<PoseSensitivity> sensitivities;
  for (const PoseRows& of_pose : rows.of_pose) {
    sensitivities.push_back({of_pose.pose, PoseBlock::Zero()});
    sensitivities.back().derivative.topRows<3>() = of_pose.derivative;
  }
  PoseBlock of_map;
  if (!propagate(sensitivities, of_map)) return false;
  of_map *= 1 / map_variance_;
  of_map(0, 0) += correlation_.variance_factor() * of_landmarks;
  const auto n = static_cast<std::size_t>(observation.rows());
  const Innovation innovation{rows.residual.head(n), of_map.topLeftCorner(n, n),
                              observation.covariance.topLeftCorner(n, n)};
  if (!again)
    judge_map_variance(
        {innovation.variance_asked_for(kMedian[n]), innovation.variance_asked_for(kTenth[n])});
  return innovation.squared(map_variance_) <= kGate[n];
}

void InformationFilter::judge_map_variance(const VarianceAskedFor& newest) {
  variances_asked_for_.push_back(newest);
  if (variances_asked_for_.size() > kLatest)
    variances_asked_for_.erase(variances_asked_for_.begin());
  const auto beyond =
      std::count_if(variances_asked_for_.begin(), variances_asked_for_.end(),
                    [this](const VarianceAskedFor& v) { return v.by_tenth > map_variance_; });
  if (beyond < kContradicting[variances_asked_for_.size()]) return;
  std::vector<double> latest{1};
  for (const VarianceAskedFor& v : variances_asked_for_) latest.push_back(v.by_median);
  map_variance_ = std::max(map_variance_, std::min(take_median(latest), kLargestVariance));
}

// As long as the positions lie almost on a line, how earth is turned about it is by chance, and the
// first one beside it may turn it by more than a derivative can tell: the best fit of all positions
// and the newest is where the filter goes on from, if it is a better one.
void InformationFilter::find_earth_again(const AbsoluteObservation& newest) {
  if (!knows(kEarthFromMap) || earth_is_certain(*this)) return;
  const PositionPairs pairs = position_pairs(&newest);
  if (pairs.in_map.cols() < 3) return;
  const DirectionPair up{Eigen::Vector3d::UnitZ(), earth_from_map_.matrix().row(2).transpose()};
  const bool is_level = has_absolute(AbsoluteObservation::Kind::kDown);
  const Rigid3 found = fit_rigid(pairs.in_earth, pairs.in_map, is_level ? &up : nullptr);
  constexpr double kBetter = 0.9;
  if (pairs.squared_error(found) < kBetter * pairs.squared_error(earth_from_map_))
    set_earth_from_map(found);
}

// With the newest, where there is one.
InformationFilter::PositionPairs InformationFilter::position_pairs(
    const AbsoluteObservation* newest) const {
  std::vector<const AbsoluteObservation*> all;
  for (const FilterAbsolute& absolute : absolutes_)
    if (absolute.observation.kind == AbsoluteObservation::Kind::kPosition)
      all.push_back(&absolute.observation);
  if (newest) all.push_back(newest);
  const auto n = static_cast<Eigen::Index>(all.size());
  PositionPairs pairs{Eigen::Matrix3Xd(3, n), Eigen::Matrix3Xd(3, n)};
  for (Eigen::Index k = 0; k < n; ++k) {
    const AbsoluteObservation& position = *all[static_cast<std::size_t>(k)];
    const RigidPoint& point = position.points.front();
    pairs.in_earth.col(k) = position.value;
    pairs.in_map.col(k) = poses_[point.pose] * point.in_pose;
  }
  return pairs;
}

double InformationFilter::PositionPairs::squared_error(const Rigid3& earth_from_map) const {
  double sum = 0;
  for (Eigen::Index k = 0; k < in_map.cols(); ++k)
    sum += (in_earth.col(k) - earth_from_map * Eigen::Vector3d(in_map.col(k))).squaredNorm();
  return sum;
}

void InformationFilter::stand_earth_upright(const Eigen::Vector3d& up_in_map) {
  const PositionPairs pairs = position_pairs(nullptr);
  if (!has_earth() || pairs.in_map.cols() == 0)
    throw std::invalid_argument("InformationFilter: there is no earth to stand upright");
  const DirectionPair up{Eigen::Vector3d::UnitZ(), up_in_map};
  set_earth_from_map(fit_rigid(pairs.in_earth, pairs.in_map, &up));
}

// Another weight concerns all of them, so a slightly other one is not worth it.
void InformationFilter::judge_absolutes() {
  constexpr double kAsGood = 1.1;
  const double weight = variance();
  if (weight < kAsGood * absolute_weight_ && absolute_weight_ < kAsGood * weight) return;
  absolute_weight_ = weight;
  for (FilterAbsolute& absolute : absolutes_) absolute.changed = true;
}

}  // namespace eifmap
