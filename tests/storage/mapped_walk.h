// Maps to be saved, of a camera among points.
#pragma once

#include <string>
#include <vector>

#include "map/map_snapshot.h"
#include "mapper.h"
#include "storage/map_rows.h"
#include "support/feature_world.h"

namespace eifmap::test {

inline const Rigid3 kEarthFromWalk{so3_exp({0.3, 1.2, -0.4}), {100, 200, -30}};

// To and fro, so that what was seen is seen again.
inline Rigid3 walk_pose(int i) {
  const int there = i % 80 < 40 ? i % 40 : 40 - i % 40;
  return {so3_exp({0, 0.002 * there, 0}), {0.1 * there, 0.01 * there, 0.02 * there}};
}

inline AbsoluteMeasurement walk_position(int i) {
  AbsoluteMeasurement m;
  m.time_us = 1'000'000 + 100'000 * i;
  m.position = kEarthFromWalk * walk_pose(i).translation;
  m.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  return m;
}

inline AbsoluteMeasurement walk_gravity(int i) {
  AbsoluteMeasurement m;
  m.kind = MeasurementKind::kGravity;
  m.time_us = 1'000'000 + 100'000 * i;
  m.down =
      (kEarthFromWalk.rotation * walk_pose(i).rotation).conjugate() * Eigen::Vector3d(0, 0, -9.81);
  m.sigma = 0.01;
  return m;
}

// Of all that a file would say of it.
inline std::uint64_t digest_of(const MapSnapshot& snapshot) {
  RowBook book;
  put_map(snapshot, nullptr, {synthetic_camera(), 0, 0, {}}, book);
  book.keep();
  return book.digest();
}

}  // namespace eifmap::test
