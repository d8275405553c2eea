#include "map/map_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "filter/calibration_share.h"
#include "filter/derived_covariances.h"
#include "filter/landmark_distance.h"
#include "map/earth_alignment.h"
#include "map/map.h"
#include "map_view.h"

namespace eifmap {
namespace {

using Kind = AbsoluteObservation::Kind;

bool is_position(const PlacedMeasurement& m) {
  return m.kind == MeasurementKind::kPosition;
}

// Whether the map is ready for those of its kind. Gravity waits until some agree, though there may
// be an earth: a way along a line does not tell how it is turned about that.
bool can_enter(const Map& map, const PlacedMeasurement& m) {
  if (is_position(m)) return map.filter().has_earth();
  if (m.kind == MeasurementKind::kGravity) return map.filter().has_absolute(Kind::kDown);
  return map.scale().state.status == ScaleStatus::kFixed;
}

bool are_landmarks(const Map& map, const PlacedMeasurement& m) {
  return std::all_of(m.tracks.begin(), m.tracks.end(),
                     [&map](int t) { return map.track(t).is_landmark(); });
}

// Of a keyframe that has one already. The errors of two in a row are much the same, so that the
// second would count for more than it is.
bool is_spare(const Map& map, const PlacedMeasurement& m) {
  if (m.kind != MeasurementKind::kGravity) return false;
  const auto keyframe_of = [&map](const PlacedMeasurement& of) {
    return of_present(map, of).points.front().keyframe;
  };
  const int keyframe = keyframe_of(m);
  const std::vector<PlacedMeasurement>& waiting = map.scale().waiting;
  return map.filter().has_absolute(keyframe, Kind::kDown) ||
         std::any_of(waiting.begin(), waiting.end(), [&](const PlacedMeasurement& other) {
           return &other != &m && other.kind == MeasurementKind::kGravity &&
                  keyframe_of(other) == keyframe;
         });
}

Reason try_to_enter(Map& map, const PlacedMeasurement& m, bool gated, bool again) {
  if (m.kind == MeasurementKind::kLandmarks && !are_landmarks(map, m))
    return Reason::kMeasurementWithoutLandmark;
  return map.filter().add_absolute(observation_in_use(map, m), gated, again);
}

Reason enter(Map& map, const PlacedMeasurement& m, bool gated) {
  const Reason reason = try_to_enter(map, m, gated, false);
  map.scale().counts.add(m.kind, reason);
  return reason;
}

// A landmark may have gone while the distance waited.
void refuse_lost_landmarks(Map& map) {
  std::erase_if(map.scale().waiting, [&map](const PlacedMeasurement& m) {
    if (m.kind != MeasurementKind::kLandmarks || are_landmarks(map, m)) return false;
    map.scale().counts.add(m.kind, Reason::kMeasurementWithoutLandmark);
    return true;
  });
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
    if (try_to_enter(map, m, true, true) != Reason::kNone) return false;
    --counts.kinds[m.kind].refused;
    if (--counts.refusals[Reason::kMeasurementGated] == 0)
      counts.refusals.erase(Reason::kMeasurementGated);
    ++counts.kinds[m.kind].used;
    return true;
  });
}

// Within one keyframe a way says nothing of how far two are from each other.
bool has_two_ends(const Map& map, const PlacedMeasurement& measurement) {
  if (measurement.kind == MeasurementKind::kLandmarks) return true;
  const std::vector<PlacedPoint> points = of_present(map, measurement).points;
  return std::any_of(points.begin(), points.end(), [&points](const PlacedPoint& point) {
    return point.keyframe != points.front().keyframe;
  });
}

// Relative: by what was measured; of landmarks, which may lie far off and be known badly, by what
// their own sights leave open too.
double sigma_of_length(const Map& map, const PlacedMeasurement& m) {
  const double measured = std::sqrt(m.covariance(0, 0)) / m.value.x();
  if (m.kind != MeasurementKind::kLandmarks) return measured;
  const InformationFilter& filter = map.filter();
  const auto landmark = [&](std::size_t k) -> const FilterLandmark& {
    return filter.landmark(map.track(m.tracks[k]).landmark);
  };
  const DistanceRows distance = linearize_distance(landmark(0), landmark(1), 0);
  const double variance = filter.variance() * (distance.of_a + distance.of_b);
  return std::hypot(measured, std::sqrt(variance) / length_in_map(map, m));
}

// The surest length that is sure enough.
const PlacedMeasurement* best_length(const Map& map, const MeasurementOptions& options) {
  const PlacedMeasurement* best = nullptr;
  double sigma_of_best = options.max_scale_sigma;
  for (const PlacedMeasurement& m : map.scale().waiting) {
    if (!is_length(m.kind) || !has_two_ends(map, m) || !(length_in_map(map, m) > 0)) continue;
    const double sigma = sigma_of_length(map, m);
    if (best ? sigma >= sigma_of_best : sigma > sigma_of_best) continue;
    best = &m;
    sigma_of_best = sigma;
  }
  return best;
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

void enter_positions(Map& map, const EarthAlignment& alignment) {
  if (map.scale().state.status == ScaleStatus::kFree)
    make_metric(map, alignment.earth_from_map.scale);
  // The positions are of the map's unit no longer where that has just changed.
  const Similarity now = fit_positions(map, alignment.inliers);
  map.filter().set_earth_from_map({Eigen::Quaterniond(now.rotation).normalized(), now.translation});
  for (const PlacedMeasurement* m : alignment.inliers) enter(map, *m, false);
  for (const PlacedMeasurement* m : alignment.outliers) {
    map.scale().counts.add(m->kind, Reason::kMeasurementGated);
    map.scale().contradicting.push_back(*m);
  }
  std::erase_if(map.scale().waiting, is_position);
}

// The least turn that brings the map upright.
Reason level_map(Map& map, const Level& level) {
  InformationFilter& filter = map.filter();
  if (!filter.has_level())
    filter.set_level(Eigen::Quaterniond::FromTwoVectors(level.up_in_map, Eigen::Vector3d::UnitZ()));
  else if (!earth_is_certain(filter))
    filter.stand_earth_upright(level.up_in_map);
  const bool gated = filter.has_earth();  // else nothing could contradict them
  for (const PlacedMeasurement* m : level.inliers) enter(map, *m, gated);
  std::vector<PlacedMeasurement>& waiting = map.scale().waiting;
  std::vector<PlacedMeasurement> others;
  for (PlacedMeasurement& m : waiting)
    if (m.kind == MeasurementKind::kGravity &&
        std::find(level.inliers.begin(), level.inliers.end(), &m) == level.inliers.end())
      others.push_back(m);
  std::erase_if(waiting,
                [](const PlacedMeasurement& m) { return m.kind == MeasurementKind::kGravity; });
  if (const Reason reason = map.update().reason; reason != Reason::kNone) return reason;
  for (const PlacedMeasurement& m : others) enter_or_keep(map, m);
  return Reason::kNone;
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

void set_earth(Map& map) {
  const InformationFilter& filter = map.filter();
  EarthState& earth = map.scale().earth;
  earth = EarthState();
  if (!filter.has_level()) return;
  earth.status = filter.has_earth() ? EarthStatus::kPlaced : EarthStatus::kLevel;
  earth.earth_from_map = filter.earth_from_map();
  PoseBlock covariance;
  if (earth_is_certain(filter) &&
      filter.propagate({{kEarthFromMap, PoseBlock::Identity()}}, covariance))
    earth.covariance = centre_first(covariance);
}

}  // namespace

void add_measurements(Map& map, std::vector<PlacedMeasurement> measurements,
                      const MeasurementOptions& options) {
  for (PlacedMeasurement& m : measurements) {
    if (is_spare(map, m))
      map.scale().counts.add(m.kind, Reason::kMeasurementSpare);
    else if (can_enter(map, m))
      enter_or_keep(map, m);
    else if (static_cast<int>(map.scale().waiting.size()) < options.max_waiting)
      map.scale().waiting.push_back(std::move(m));
    else
      map.scale().counts.add(m.kind, Reason::kTooManyMeasurements);
  }
  if (!measurements.empty()) enter_kept(map);
}

bool is_spare(const Map& map, int keyframe) {
  // Of the scale's logarithm: a position that goes of n adds a 2n-th to it, and where it is nearer
  // to max_scale_sigma each has a say.
  constexpr double kSureScale = 0.02;
  constexpr int kAround = 5;  // keyframes of its surroundings, itself among them
  const InformationFilter& filter = map.filter();
  if (filter.has_absolute(keyframe, Kind::kLength)) return false;
  constexpr std::size_t kFewSights = 3;
  for (int t : map.measured_tracks())
    for (const Sight& sight : map.track(t).sights)
      if (sight.keyframe == keyframe && map.track(t).sights.size() <= kFewSights) return false;
  const bool is_level = filter.has_absolute(keyframe, Kind::kDown);
  const bool is_placed = filter.has_absolute(keyframe, Kind::kPosition);
  if (!is_level && !is_placed) return true;  // asked of many keyframes: before what takes long
  const std::vector<int> around = map.covisible(keyframe, kAround);
  const auto is_elsewhere = [&](Kind kind) {
    return std::any_of(around.begin(), around.end(), [&](int other) {
      return other != keyframe && filter.has_absolute(other, kind);
    });
  };
  if (is_level && !is_elsewhere(Kind::kDown)) return false;
  if (!is_placed) return true;
  return map.scale().state.sigma <= kSureScale && is_elsewhere(Kind::kPosition);
}

Reason fix_scale(Map& map, const MeasurementOptions& options) {
  refuse_lost_landmarks(map);
  const auto is_metric = [&map] { return map.scale().state.status == ScaleStatus::kFixed; };
  if (!map.filter().has_absolute(Kind::kDown))
    if (const auto level = find_level(map))
      if (const Reason reason = level_map(map, *level); reason != Reason::kNone) return reason;
  if (!is_metric())
    if (const PlacedMeasurement* length = best_length(map, options)) {
      make_metric_by(map, *length);
      if (const Reason reason = map.update().reason; reason != Reason::kNone) return reason;
      std::vector<PlacedMeasurement> others = std::exchange(map.scale().waiting, {});
      add_measurements(map, std::move(others), options);
    }
  if (!map.filter().has_earth())
    if (const auto alignment = align_positions(map, options)) {
      enter_positions(map, *alignment);
      if (const Reason reason = map.update().reason; reason != Reason::kNone) return reason;
    }
  judge_scale(map, options);
  return Reason::kNone;
}

void judge_scale(Map& map, const MeasurementOptions& options) {
  if (map.scale().state.status == ScaleStatus::kFixed) set_sigmas(map, options);
  set_earth(map);
}

}  // namespace eifmap
