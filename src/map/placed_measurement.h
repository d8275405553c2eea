// An absolute measurement that has found its place in the map: points fixed to keyframes, or
// landmarks.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "absolute_measurement.h"
#include "filter/absolute_observation.h"
#include "geometry/rigid3.h"

namespace eifmap {

class Map;

// In the keyframe's camera frame. What the map says and what was measured on the camera are kept
// apart, since only the one is scaled when the map becomes metric.
struct PlacedPoint {
  int keyframe = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // of another frame's centre; map units
  Eigen::Vector3d lever = Eigen::Vector3d::Zero();   // from there; m
  // What the other frame's own uncertainty adds, given the keyframe.
  Eigen::Matrix3d offset_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d lever_covariance = Eigen::Matrix3d::Zero();
  // What is in the map's unit.
  void grow(double factor) {
    offset *= factor;
    offset_covariance *= factor * factor;
  }
};

struct PlacedMeasurement {
  MeasurementKind kind = MeasurementKind::kPosition;
  std::vector<PlacedPoint> points;       // of gravity one, of which the keyframe alone counts
  std::array<int, 2> tracks = {-1, -1};  // of the distance of two landmarks, which has no points
  // m; of a length the first. Of gravity down, unit, in the keyframe's camera frame.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  // Of a length (0, 0), of gravity that of a turn, rad^2, in the keyframe's camera frame.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  void make_metric(double metres_per_unit) {
    for (PlacedPoint& point : points) point.grow(metres_per_unit);
  }
};

// In the map, its levers in units of the map.
Eigen::Vector3d in_map(const Map& map, const PlacedPoint& point, double metres_per_unit);

// The same of keyframes that are in the map: where one has been removed, of what carries it.
PlacedMeasurement of_present(const Map& map, PlacedMeasurement measurement);

// Of a length, in the map's unit: 0 where a landmark is none any more.
double length_in_map(const Map& map, const PlacedMeasurement& measurement);

// As the filter takes it, of a metric map (gravity: of any). What the points' frames are uncertain
// by is added, as things are now. Of landmarks that are no more the handles are -1.
AbsoluteObservation observation_in_use(const Map& map, const PlacedMeasurement& measurement);

}  // namespace eifmap
