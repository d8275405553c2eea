#include "map/map_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "filter/calibration_share.h"
#include "filter/derived_covariances.h"
#include "geometry/robust.h"
#include "geometry/similarity.h"
#include "map/map.h"

namespace eifmap {
namespace {

bool is_position(const PlacedMeasurement& m) {
  return m.kind == MeasurementKind::kPosition;
}

// In the map, its levers in units of the map.
Eigen::Vector3d in_map(const Map& map, const PlacedPoint& point, double metres_per_unit) {
  return map.pose(point.keyframe) * Eigen::Vector3d(point.offset + point.lever / metres_per_unit);
}

// The same point, of the keyframe that carries a removed one.
PlacedPoint of_present(const Map& map, PlacedPoint point) {
  if (!map.is_removed(point.keyframe)) return point;
  const Keyframe& removed = map.keyframe(point.keyframe);
  const Eigen::Matrix3d turn = removed.carrier_from_this.matrix();
  point.keyframe = removed.carrier;
  point.offset = removed.carrier_from_this * point.offset;
  point.lever = turn * point.lever;
  point.offset_covariance = turn * point.offset_covariance * turn.transpose();
  point.lever_covariance = turn * point.lever_covariance * turn.transpose();
  return point;
}

// Of a metric map. What the points' frames are uncertain by is added, as things are now.
AbsoluteObservation observation_of(const Map& map, const PlacedMeasurement& m) {
  std::vector<RigidPoint> points;
  for (const PlacedPoint& p : m.points) points.emplace_back(p.keyframe, p.offset + p.lever);
  const auto added = [&map](const PlacedPoint& p) {
    const Eigen::Matrix3d turn = map.pose(p.keyframe).matrix();
    return Eigen::Matrix3d(turn * (p.offset_covariance + p.lever_covariance) * turn.transpose());
  };
  if (is_position(m)) {
    const Eigen::Matrix3d turn = map.filter().earth_from_map().matrix();
    return AbsoluteObservation::position(
        points.front(), m.value, m.covariance + turn * added(m.points.front()) * turn.transpose());
  }
  const auto n = m.points.size();
  const auto along = [&](std::size_t a, std::size_t b) {
    const Eigen::Vector3d step = in_map(map, m.points[b], 1) - in_map(map, m.points[a], 1);
    return Eigen::Vector3d(step / std::max(step.norm(), 1e-12));
  };
  const Eigen::Vector3d first = along(0, 1), last = along(n - 2, n - 1);
  const double variance = m.covariance(0, 0) + first.dot(added(m.points.front()) * first) +
                          last.dot(added(m.points.back()) * last);
  return AbsoluteObservation::length(std::move(points), m.value.x(), std::sqrt(variance));
}

AbsoluteObservation observation_in_use(const Map& map, PlacedMeasurement m) {
  for (PlacedPoint& point : m.points) point = of_present(map, point);
  return observation_of(map, m);
}

Reason enter(Map& map, const PlacedMeasurement& m, bool gated) {
  const Reason reason = map.filter().add_absolute(observation_in_use(map, m), gated);
  map.scale().counts.add(m.kind, reason);
  return reason;
}

void enter_or_keep(Map& map, const PlacedMeasurement& m) {
  constexpr std::size_t kMostKept = 50;
  if (enter(map, m, true) != Reason::kMeasurementGated) return;
  std::vector<PlacedMeasurement>& kept = map.scale().contradicting;
  kept.push_back(m);
  if (kept.size() > kMostKept) kept.erase(kept.begin());
}

void enter_kept(Map& map) {
  MeasurementCounts& counts = map.scale().counts;
  std::erase_if(map.scale().contradicting, [&](const PlacedMeasurement& m) {
    if (map.filter().add_absolute(observation_in_use(map, m), true, true) != Reason::kNone)
      return false;
    --counts.kinds[m.kind].refused;
    if (--counts.refusals[Reason::kMeasurementGated] == 0)
      counts.refusals.erase(Reason::kMeasurementGated);
    ++counts.kinds[m.kind].used;
    return true;
  });
}

double length_in_map(const Map& map, const PlacedMeasurement& m) {
  double length = 0;
  for (std::size_t k = 1; k < m.points.size(); ++k)
    length += (in_map(map, m.points[k], 1) - in_map(map, m.points[k - 1], 1)).norm();
  return length;
}

// Within one keyframe a length says nothing of how far two are from each other.
bool has_two_ends(const Map& map, const PlacedMeasurement& m) {
  const int first = of_present(map, m.points.front()).keyframe;
  return std::any_of(m.points.begin(), m.points.end(), [&](const PlacedPoint& point) {
    return of_present(map, point).keyframe != first;
  });
}

// The surest length that is sure enough.
const PlacedMeasurement* best_length(const Map& map, const MeasurementOptions& options) {
  const PlacedMeasurement* best = nullptr;
  const auto relative = [](const PlacedMeasurement& m) {
    return std::sqrt(m.covariance(0, 0)) / m.value.x();
  };
  for (const PlacedMeasurement& m : map.scale().waiting)
    if (!is_position(m) && has_two_ends(map, m) && relative(m) <= options.max_scale_sigma &&
        length_in_map(map, m) > 0 && (!best || relative(m) < relative(*best)))
      best = &m;
  return best;
}

struct Alignment {
  Similarity earth_from_map;
  std::vector<const PlacedMeasurement*> inliers, outliers;
};

Similarity fit(const Map& map, const std::vector<const PlacedMeasurement*>& positions) {
  const auto n = static_cast<Eigen::Index>(positions.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  Similarity found;
  // Levers are metres, the rest is in units of the map: again with the scale found.
  for (int pass = 0; pass < 4; ++pass) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const PlacedMeasurement& m = *positions[static_cast<std::size_t>(k)];
      const PlacedPoint& point = m.points.front();
      const Eigen::Vector3d lever = map.pose(point.keyframe).rotation * point.lever;
      a.col(k) = m.value - (pass > 0 ? Eigen::Vector3d(found.rotation * lever)
                                     : Eigen::Vector3d(Eigen::Vector3d::Zero()));
      b.col(k) = map.pose(point.keyframe) * point.offset;
    }
    found = fit_similarity(a, b);
  }
  return found;
}

// The similarity that brings the map to the positions, when they determine its scale well enough.
// The errors are taken from the residuals, which have the map's own in them, but for no less than
// what the positions claim.
std::optional<Alignment> align(const Map& map, const MeasurementOptions& options) {
  constexpr double kOutlier = 4.6;              // spreads: 1 in 10,000, of three axes
  constexpr double kSpreadFromMedian3d = 0.65;  // of one axis from the median norm of three
  Alignment found;
  for (const PlacedMeasurement& m : map.scale().waiting)
    if (is_position(m)) found.inliers.push_back(&m);
  const std::size_t all = found.inliers.size();
  const auto wanted = static_cast<std::size_t>(options.min_positions);
  for (int round = 0; round < 5; ++round) {
    if (found.inliers.size() < wanted || 2 * found.inliers.size() < all) return std::nullopt;
    const Similarity& s = found.earth_from_map = fit(map, found.inliers);
    if (!(s.scale > 0)) return std::nullopt;
    const auto residual = [&](const PlacedMeasurement& m) {
      return (m.value - s * in_map(map, m.points.front(), s.scale)).norm();
    };
    std::vector<double> residuals;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double claimed = 0, squared = 0, spread_out = 0;
    const auto n = static_cast<double>(found.inliers.size());
    for (const PlacedMeasurement* m : found.inliers) {
      residuals.push_back(residual(*m));
      squared += std::pow(residuals.back(), 2);
      claimed += m->covariance.trace() / (3 * n);
      mean += map.pose(m->points.front().keyframe).translation / n;
    }
    for (const PlacedMeasurement* m : found.inliers)
      spread_out += (map.pose(m->points.front().keyframe).translation - mean).squaredNorm();
    const double spread =
        std::max(std::sqrt(claimed), kSpreadFromMedian3d * take_median(residuals));
    const auto first_out = std::stable_partition(
        found.inliers.begin(), found.inliers.end(),
        [&](const PlacedMeasurement* m) { return residual(*m) <= kOutlier * spread; });
    if (first_out == found.inliers.end()) {
      const double variance = std::max(claimed, squared / (3 * n - 7));
      const double sigma = std::sqrt(variance / spread_out) / s.scale;
      return sigma <= options.max_scale_sigma ? std::optional(found) : std::nullopt;
    }
    found.outliers.insert(found.outliers.end(), first_out, found.inliers.end());
    found.inliers.erase(first_out, found.inliers.end());
  }
  return std::nullopt;
}

// Everything that is in units of the map.
void make_metric(Map& map, double metres_per_unit) {
  map.make_metric(metres_per_unit);
  for (PlacedMeasurement& m : map.scale().waiting) m.make_metric(metres_per_unit);
  map.scale().state.status = ScaleStatus::kFixed;
  map.scale().state.metres_per_unit = metres_per_unit;
}

void make_metric_by(Map& map, const PlacedMeasurement& length) {
  make_metric(map, length.value.x() / length_in_map(map, length));
  enter(map, length, false);
  std::vector<PlacedMeasurement>& waiting = map.scale().waiting;
  waiting.erase(waiting.begin() + (&length - waiting.data()));
}

void enter_positions(Map& map, const Alignment& alignment) {
  if (map.scale().state.status == ScaleStatus::kFree)
    make_metric(map, alignment.earth_from_map.scale);
  // The positions are of the map's unit no longer where that has just changed.
  const Similarity now = fit(map, alignment.inliers);
  map.filter().set_earth_from_map({Eigen::Quaterniond(now.rotation).normalized(), now.translation});
  for (const PlacedMeasurement* m : alignment.inliers) enter(map, *m, false);
  for (const PlacedMeasurement* m : alignment.outliers) {
    map.scale().counts.add(m->kind, Reason::kMeasurementGated);
    map.scale().contradicting.push_back(*m);
  }
  std::erase_if(map.scale().waiting, is_position);
}

// NaN where the filter cannot tell.
double log_scale_sigma(const Map& map, const std::vector<int>& poses,
                       const CalibrationShare& calibration) {
  double of_errors = 0, of_calibration = 0;
  if (!log_scale_variance(map.filter(), poses, of_errors) ||
      !calibration.variance(poses, of_calibration))
    return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(of_errors + of_calibration);
}

void set_sigmas(Map& map, const MeasurementOptions& options) {
  constexpr std::size_t kLatest = 10;
  std::vector<int> all, latest;
  for (int k = map.num_keyframes() - 1; k >= 0; --k) {
    if (map.is_removed(k)) continue;
    all.push_back(k);
    if (latest.size() < kLatest) latest.push_back(k);
  }
  const CalibrationShare calibration(
      map.filter(), {options.focal_sigma, options.centre_sigma_px * map.radians_per_pixel(),
                     options.radial_sigma});
  map.scale().state.sigma = log_scale_sigma(map, all, calibration);
  map.scale().state.sigma_newest = log_scale_sigma(map, latest, calibration);
}

}  // namespace

void add_measurements(Map& map, std::vector<PlacedMeasurement> measurements,
                      const MeasurementOptions& options) {
  const bool is_metric = map.scale().state.status == ScaleStatus::kFixed;
  for (PlacedMeasurement& m : measurements) {
    if (is_metric && (!is_position(m) || map.filter().has_earth()))
      enter_or_keep(map, m);
    else if (static_cast<int>(map.scale().waiting.size()) < options.max_waiting)
      map.scale().waiting.push_back(std::move(m));
    else
      map.scale().counts.add(m.kind, Reason::kTooManyMeasurements);
  }
  if (is_metric && !measurements.empty()) enter_kept(map);
}

bool is_spare(const Map& map, int keyframe) {
  // Of the scale's logarithm: a position that goes of n adds a 2n-th to it, and where it is nearer
  // to max_scale_sigma each has a say.
  constexpr double kSureScale = 0.02;
  constexpr int kAround = 5;  // keyframes of its surroundings, itself among them
  using Kind = AbsoluteObservation::Kind;
  const InformationFilter& filter = map.filter();
  if (filter.has_absolute(keyframe, Kind::kLength)) return false;
  if (!filter.has_absolute(keyframe, Kind::kPosition)) return true;
  if (!(map.scale().state.sigma <= kSureScale)) return false;
  const std::vector<int> around = map.covisible(keyframe, kAround);
  return std::any_of(around.begin(), around.end(), [&](int other) {
    return other != keyframe && filter.has_absolute(other, Kind::kPosition);
  });
}

Reason fix_scale(Map& map, const MeasurementOptions& options) {
  const auto is_metric = [&map] { return map.scale().state.status == ScaleStatus::kFixed; };
  if (!is_metric())
    if (const PlacedMeasurement* length = best_length(map, options)) {
      make_metric_by(map, *length);
      if (const Reason reason = map.update().reason; reason != Reason::kNone) return reason;
      std::vector<PlacedMeasurement> others = std::exchange(map.scale().waiting, {});
      add_measurements(map, std::move(others), options);
    }
  if (!map.filter().has_earth())
    if (const auto alignment = align(map, options)) {
      enter_positions(map, *alignment);
      if (const Reason reason = map.update().reason; reason != Reason::kNone) return reason;
    }
  if (is_metric()) set_sigmas(map, options);
  return Reason::kNone;
}

}  // namespace eifmap
