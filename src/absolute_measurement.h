// Absolute measurements as the mapper is given them: metres, the clock of the frames. They fix the
// map's scale, and from then on hold it.
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>
#include <vector>

#include "reason.h"

namespace eifmap {

enum class MeasurementKind : std::int8_t {
  kPosition = 0,  // of a point on the camera, in a frame of its own (GPS in local coordinates)
  kDistance = 1,  // between the camera's places at two times
  kOdometry = 2,  // of the way between two times: counted as straight from keyframe to keyframe
};
std::string_view name(MeasurementKind kind);

// What its publisher calls it, for the decisions of a run (decision.h).
struct MeasurementId {
  std::int64_t publisher = 0, seq = -1;  // -1: nothing
  auto operator<=>(const MeasurementId&) const = default;
};

struct AbsoluteMeasurement {
  MeasurementId id = {};
  MeasurementKind kind = MeasurementKind::kPosition;
  std::int64_t time_us = 0;
  std::int64_t until_us = 0;  // not of a position: the other end, later
  // Of a position:
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  Eigen::Vector3d lever = Eigen::Vector3d::Zero();  // of the point, in the camera's frame
  // Of the others:
  double length = 0, sigma = 0;
};

// When it can be used: a position's time, the later of the two of a length.
inline std::int64_t usable_from_us(const AbsoluteMeasurement& m) {
  return m.kind == MeasurementKind::kPosition ? m.time_us : m.until_us;
}

// kNone, kBadMeasurement or kBadMeasurementCovariance: of the numbers alone.
Reason check_measurement(const AbsoluteMeasurement& measurement);

struct MeasurementCounts {
  struct OfKind {
    std::int64_t used = 0, refused = 0;
    std::int64_t dropped = 0;  // of those used, with a keyframe that was redundant
  };
  std::map<MeasurementKind, OfKind> kinds;
  std::map<Reason, std::int64_t> refusals;

  void add(MeasurementKind kind, Reason reason) {  // kNone: used
    ++(reason == Reason::kNone ? kinds[kind].used : kinds[kind].refused);
    if (reason != Reason::kNone) ++refusals[reason];
  }
  MeasurementCounts& operator+=(const MeasurementCounts& other);
};

// The wire's values.
enum class ScaleStatus : std::int8_t { kFree = 0, kFixed = 1 };

struct ScaleState {
  ScaleStatus status = ScaleStatus::kFree;
  double metres_per_unit = 1;  // kFixed: what the map's lengths were multiplied by when it was
  // Standard deviations of the scale's logarithm, with what the calibration may be off by
  // (MeasurementOptions); NaN: unknown.
  // That of all the map, as all its keyframes together show it.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  // That at the newest keyframes, as the latest ten show it: what a length that is measured here
  // and now is off by. It grows with the way from what fixed the scale.
  double sigma_newest = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace eifmap
