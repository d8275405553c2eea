// Keyframes of a known world in a Map, for the tests of the map's parts.
#pragma once

#include "map/map.h"
#include "support/feature_world.h"

namespace eifmap::test {

inline ObservedFrame observed_view(const SyntheticStream& world, int i,
                                   const Rigid3& world_from_camera) {
  const MapperOptions options;
  return observe(world.view(i, world_from_camera), synthetic_camera(), MapSign::kMinus,
                 options.sigma_factor);
}

// The i-th keyframe's true pose.
inline Rigid3 scene_pose(int i) {
  return {so3_exp({0, 0.01 * i, 0}), {0.5 * i, 0, 0.05 * i}};
}

inline Map make_scene(const SyntheticStream& world, int keyframes,
                      const MapperOptions& options = {}) {
  Map map(synthetic_camera(), options);
  for (int i = 0; i < keyframes; ++i)
    map.add_keyframe(observed_view(world, i, scene_pose(i)), scene_pose(i));
  return map;
}

}  // namespace eifmap::test
