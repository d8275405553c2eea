#include "map/placed_measurement.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "map/map.h"

namespace eifmap {
namespace {

// What the point's frame is uncertain by, in the map.
Eigen::Matrix3d added_by(const Map& map, const PlacedPoint& point) {
  const Eigen::Matrix3d turn = map.pose(point.keyframe).matrix();
  return turn * (point.offset_covariance + point.lever_covariance) * turn.transpose();
}

AbsoluteObservation position_of(const Map& map, const PlacedMeasurement& m) {
  const PlacedPoint& point = m.points.front();
  const Eigen::Matrix3d turn = map.filter().earth_from_map().matrix();
  return AbsoluteObservation::position(
      {point.keyframe, point.offset + point.lever}, m.value,
      m.covariance + turn * added_by(map, point) * turn.transpose());
}

AbsoluteObservation way_of(const Map& map, const PlacedMeasurement& m) {
  std::vector<RigidPoint> points;
  for (const PlacedPoint& p : m.points) points.emplace_back(p.keyframe, p.offset + p.lever);
  const auto n = m.points.size();
  const auto along = [&](std::size_t a, std::size_t b) {
    const Eigen::Vector3d step = in_map(map, m.points[b], 1) - in_map(map, m.points[a], 1);
    return Eigen::Vector3d(step / std::max(step.norm(), 1e-12));
  };
  const Eigen::Vector3d first = along(0, 1), last = along(n - 2, n - 1);
  const double variance = m.covariance(0, 0) + first.dot(added_by(map, m.points.front()) * first) +
                          last.dot(added_by(map, m.points.back()) * last);
  return AbsoluteObservation::length(std::move(points), m.value.x(), std::sqrt(variance));
}

}  // namespace

Eigen::Vector3d in_map(const Map& map, const PlacedPoint& point, double metres_per_unit) {
  return map.pose(point.keyframe) * Eigen::Vector3d(point.offset + point.lever / metres_per_unit);
}

PlacedMeasurement of_present(const Map& map, PlacedMeasurement m) {
  for (PlacedPoint& point : m.points) {
    if (!map.is_removed(point.keyframe)) continue;
    const Keyframe& removed = map.keyframe(point.keyframe);
    const Eigen::Matrix3d turn = removed.carrier_from_this.matrix();
    point.keyframe = removed.carrier;
    point.offset = removed.carrier_from_this * point.offset;
    point.lever = turn * point.lever;
    point.offset_covariance = turn * point.offset_covariance * turn.transpose();
    point.lever_covariance = turn * point.lever_covariance * turn.transpose();
    if (m.kind != MeasurementKind::kGravity) continue;
    m.value = turn * m.value;
    m.covariance = turn * m.covariance * turn.transpose();
  }
  return m;
}

double length_in_map(const Map& map, const PlacedMeasurement& m) {
  if (m.kind == MeasurementKind::kLandmarks) {
    const auto [a, b] = m.tracks;
    if (!map.track(a).is_landmark() || !map.track(b).is_landmark()) return 0;
    return (map.position(a) - map.position(b)).norm();
  }
  double length = 0;
  for (std::size_t k = 1; k < m.points.size(); ++k)
    length += (in_map(map, m.points[k], 1) - in_map(map, m.points[k - 1], 1)).norm();
  return length;
}

AbsoluteObservation observation_in_use(const Map& map, const PlacedMeasurement& measurement) {
  const PlacedMeasurement m = of_present(map, measurement);
  switch (m.kind) {
    case MeasurementKind::kPosition:
      return position_of(map, m);
    case MeasurementKind::kGravity:
      return AbsoluteObservation::down(m.points.front().keyframe, m.value, m.covariance);
    case MeasurementKind::kLandmarks:
      return AbsoluteObservation::distance(map.track(m.tracks[0]).landmark,
                                           map.track(m.tracks[1]).landmark, m.value.x(),
                                           std::sqrt(m.covariance(0, 0)));
    case MeasurementKind::kDistance:
    case MeasurementKind::kOdometry:
      break;
  }
  return way_of(map, m);
}

}  // namespace eifmap
