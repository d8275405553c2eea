// Absolute measurements as the mapper is given them: metres, the clock of the frames. They fix the
// map's scale, and from then on hold it; gravity levels the map.
#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>
#include <vector>

#include "geometry/rigid3.h"
#include "reason.h"

namespace eifmap {

enum class MeasurementKind : std::int8_t {
  kPosition = 0,   // of a point on the camera, in a frame of its own (GPS in local coordinates)
  kDistance = 1,   // between the camera's places at two times
  kOdometry = 2,   // of the way between two times: counted as straight from keyframe to keyframe
  kGravity = 3,    // which way is down, seen from the camera
  kLandmarks = 4,  // distance of two landmarks
};
std::string_view name(MeasurementKind kind);
inline bool has_two_times(MeasurementKind kind) {
  return kind == MeasurementKind::kDistance || kind == MeasurementKind::kOdometry;
}
inline bool is_length(MeasurementKind kind) {
  return has_two_times(kind) || kind == MeasurementKind::kLandmarks;
}

// What its publisher calls it, for the decisions of a run (decision.h).
struct MeasurementId {
  std::int64_t publisher = 0, seq = -1;  // -1: nothing
  auto operator<=>(const MeasurementId&) const = default;
};

struct AbsoluteMeasurement {
  MeasurementId id = {};
  MeasurementKind kind = MeasurementKind::kPosition;
  std::int64_t time_us = 0;
  std::int64_t until_us = 0;  // with two times: the other end, later
  // Of a position:
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  Eigen::Vector3d lever = Eigen::Vector3d::Zero();  // of the point, in the camera's frame
  // Of gravity: in the camera's frame, of any length but 0. Earth's z axis is up.
  Eigen::Vector3d down = Eigen::Vector3d::Zero();
  // Of the distance of two landmarks: LandmarkView::id, of that map.
  std::int64_t map_id = 0;
  std::array<std::int64_t, 2> landmark = {-1, -1};
  // Of all lengths:
  double length = 0;
  double sigma = 0;  // of lengths, m; of gravity, rad, of a turn about each axis
};

// When it can be used: the later of two times.
inline std::int64_t usable_from_us(const AbsoluteMeasurement& m) {
  return has_two_times(m.kind) ? m.until_us : m.time_us;
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

// The wire's values. Level: earth's z axis is up, and where its origin is and how it is turned
// about that are by definition.
enum class EarthStatus : std::int8_t { kUnknown = 0, kLevel = 1, kPlaced = 2 };

// How a map lies in "earth", the frame that positions are measured in.
struct EarthState {
  EarthStatus status = EarthStatus::kUnknown;
  Rigid3 earth_from_map;
  // Of (displacement in earth, rotation vector in the map's frame); all NaN where positions on a
  // line leave its turn about that open, and while the status is unknown.
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Constant(std::numeric_limits<double>::quiet_NaN());
};

}  // namespace eifmap
