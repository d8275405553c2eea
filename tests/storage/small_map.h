// The smallest map worth the name: a few points, seen from three places.
#pragma once

#include <memory>

#include "map/map_snapshot.h"
#include "map/observed_frame.h"
#include "support/feature_world.h"

namespace eifmap::test {

inline FeatureFrame small_frame(int k, const std::vector<Eigen::Vector3d>& points,
                                const Rigid3& world_from_camera) {
  const Camera camera = synthetic_camera();
  FeatureFrame frame;
  frame.time_us = 1'000'000 + 100'000 * k;
  frame.publisher = 7;
  frame.seq = k;
  frame.calibration_id = camera.id();
  frame.width = camera.width;
  frame.height = camera.height;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector3d x = world_from_camera.inverse() * points[p];
    const Eigen::Vector2d pixel = camera.pixel_from_normalized(x.hnormalized());
    frame.keypoints.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 0.5f,
                               2.0f, 0.0f, 1.0f / static_cast<float>(p + 1),
                               static_cast<std::int8_t>(p % 4 == 3 ? 1 : -1)});
    for (int d = 0; d < kDescriptorSize; ++d)
      frame.descriptors.push_back(static_cast<std::int8_t>((31 * p + 7 * d) % 64) - 32);
  }
  return frame;
}

inline MapSnapshot small_map() {
  std::vector<Eigen::Vector3d> points;
  for (int p = 0; p < 12; ++p)
    points.push_back({-0.8 + 0.75 * (p % 4), -1.0 + 0.9 * (p / 4), 4 + 0.3 * (p % 5)});
  const MapperOptions options;
  auto map = std::make_shared<Map>(synthetic_camera(), options);
  MapSnapshot snapshot;
  for (int k = 0; k < 3; ++k) {
    const Rigid3 pose(so3_exp({0, 0.02 * k, 0}), {0.5 * k, 0.05 * k, 0});
    map->add_keyframe(observe(small_frame(k, points, pose), synthetic_camera(), MapSign::kMinus,
                              options.sigma_factor),
                      pose);
    snapshot.log.add(1'000'000 + 100'000 * k, k, Rigid3());
    snapshot.most_tracked.push_back(9);
  }
  for (int p = 0; p < 12; ++p) {
    if (p % 4 == 3) continue;
    const int track = map->add_track({0, p});
    for (int k = 1; k < 3; ++k) map->add_sight(track, {k, p});
    if (p != 10) map->promote(track, points[static_cast<std::size_t>(p)], Eigen::Matrix3d::Zero());
  }
  map->update();
  snapshot.map_id = 1;
  snapshot.map = map;
  snapshot.reference = 2;
  return snapshot;
}

}  // namespace eifmap::test
