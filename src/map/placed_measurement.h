// An absolute measurement that has found its place in the map: points fixed to keyframes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absolute_measurement.h"
#include "filter/absolute_observation.h"
#include "geometry/rigid3.h"

namespace eifmap {

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
  std::vector<PlacedPoint> points;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();           // m; of a length the first
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // of a length (0, 0)
  void make_metric(double metres_per_unit) {
    for (PlacedPoint& point : points) point.grow(metres_per_unit);
  }
};

}  // namespace eifmap
