// How absolute measurements enter the filter, and what they say of the map's scale.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "filter/derived_covariances.h"
#include "filter/information_filter.h"
#include "geometry/robust.h"
#include "geometry/similarity.h"

namespace eifmap {
namespace {

// Chi-square, 1 in 10,000, by degrees of freedom: beyond it a measurement contradicts the map.
constexpr double kGateOfLength = 15.1, kGateOfPosition = 21.1;

// A map that was right so far may no longer be: so many innovations are judged together, as if one
// more had been as large as it should. And the most that a map may be worse than it says.
constexpr std::size_t kLatest = 8;
constexpr double kLargestVariance = 400;

// Of n innovations as large as they should be, this many or more are beyond what 1 in 10 is beyond
// in 2 of 1,000 cases at most. So the map contradicts them. Their median alone would not do: where
// measurements are noisier than the map, it asks for any variance, now a large one and now a small
// one, and of those the largest stayed.
constexpr std::array<int, kLatest + 1> kContradicting = {9, 9, 9, 3, 4, 4, 4, 5, 5};
// Chi-square of lengths (1) and positions (3): the median, and beyond what 1 in 10 is.
constexpr double kMedianOf1 = 0.455, kMedianOf3 = 2.366, kTenthOf1 = 2.706, kTenthOf3 = 6.251;

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
    FilterLandmark& landmark = landmarks_.write(l);
    landmark.position *= metres_per_unit;
    landmark.covariance *= metres_per_unit * metres_per_unit;
  }
  for (auto& [landmark, position] : positions_before_) position *= metres_per_unit;
  gauge_.length = 0;
  system_.set_gauge(gauge_);
  is_metric_ = true;
  linearize_all_anew();
}

void InformationFilter::set_earth_from_map(const Rigid3& earth_from_map) {
  if (!is_metric_)
    throw std::invalid_argument("InformationFilter: earth_from_map of a map without scale");
  if (!has_earth()) system_.append_earth(num_poses());
  earth_from_map_ = earth_from_map;
  for (FilterAbsolute& absolute : absolutes_) absolute.linearized = false, absolute.changed = true;
}

Reason InformationFilter::add_absolute(const AbsoluteObservation& observation, bool gated,
                                       bool again) {
  using Kind = AbsoluteObservation::Kind;
  if (!is_metric_) throw std::invalid_argument("InformationFilter: the map has no scale yet");
  const std::size_t wanted = observation.kind == Kind::kPosition ? 1 : 2;
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
  FilterAbsolute absolute;
  absolute.observation = observation;
  if (!whitening(observation, absolute.whiten)) return Reason::kBadMeasurementCovariance;
  if (observation.kind == Kind::kLength && !has_baseline(observation))
    return Reason::kMeasurementWithoutBaseline;
  if (gated) {
    for (const RigidPoint& point : observation.points)
      if (!knows(point.pose)) return Reason::kMeasurementWithoutPose;
    const Rigid3 before = earth_from_map_;
    if (observation.kind == Kind::kPosition) find_earth_again(observation);
    if (!passes_gate(absolute, again)) {
      if (has_earth()) set_earth_from_map(before);
      return Reason::kMeasurementGated;
    }
  }
  absolutes_.push_back(std::move(absolute));
  return Reason::kNone;
}

// Whether it says anything of where poses are to each other.
bool InformationFilter::has_baseline(const AbsoluteObservation& observation) const {
  constexpr double kLittle = 1e-6;
  double squared = 0;
  for (const PoseRows& rows : linearize(observation, poses_, earth_from_map_).of_pose)
    squared += rows.derivative.rightCols<3>().squaredNorm();
  return squared > kLittle;
}

// By the innovation at the mean, whose covariance is the measurement's and that of the poses and of
// earth_from_map together.
bool InformationFilter::passes_gate(const FilterAbsolute& absolute, bool again) {
  const AbsoluteObservation& observation = absolute.observation;
  const AbsoluteRows rows = linearize(observation, poses_, earth_from_map_);
  std::vector<PoseSensitivity> sensitivities;
  for (const PoseRows& of_pose : rows.of_pose) {
    sensitivities.push_back({of_pose.pose, PoseBlock::Zero()});
    sensitivities.back().derivative.topRows<3>() = of_pose.derivative;
  }
  PoseBlock of_map;
  if (!propagate(sensitivities, of_map)) return false;
  const int n = observation.rows();
  const Innovation innovation{rows.residual.head(n), of_map.topLeftCorner(n, n) / map_variance_,
                              observation.covariance.topLeftCorner(n, n)};
  if (!again)
    judge_map_variance({innovation.variance_asked_for(n == 1 ? kMedianOf1 : kMedianOf3),
                        innovation.variance_asked_for(n == 1 ? kTenthOf1 : kTenthOf3)});
  return innovation.squared(map_variance_) <= (n == 1 ? kGateOfLength : kGateOfPosition);
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
  std::vector<const AbsoluteObservation*> all;
  for (const FilterAbsolute& absolute : absolutes_)
    if (absolute.observation.kind == AbsoluteObservation::Kind::kPosition)
      all.push_back(&absolute.observation);
  all.push_back(&newest);
  if (all.size() < 3) return;
  Eigen::Matrix3Xd in_earth(3, all.size()), in_map(3, all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const RigidPoint& point = all[k]->points.front();
    in_earth.col(static_cast<Eigen::Index>(k)) = all[k]->value;
    in_map.col(static_cast<Eigen::Index>(k)) = poses_[point.pose] * point.in_pose;
  }
  const Rigid3 found = fit_rigid(in_earth, in_map);
  const auto squared = [&](const Rigid3& earth_from_map) {
    double sum = 0;
    for (Eigen::Index k = 0; k < in_map.cols(); ++k)
      sum += (in_earth.col(k) - earth_from_map * Eigen::Vector3d(in_map.col(k))).squaredNorm();
    return sum;
  };
  constexpr double kBetter = 0.9;
  if (squared(found) < kBetter * squared(earth_from_map_)) set_earth_from_map(found);
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
