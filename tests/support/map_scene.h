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

// Landmarks from true poses: extend_tracks needs neighbours, which need landmarks.
inline Map scene_with_landmarks(const SyntheticStream& world, int keyframes) {
  MapperOptions options;
  Map map = make_scene(world, keyframes, options);
  const auto& first = map.keyframe(0).observed();
  const auto& second = map.keyframe(1).observed();
  for (const Match& m : match_omega_m(first, second, options.match)) {
    const int track = map.add_track({0, m.a});
    map.add_sight(track, {1, m.b});
    for (int k = 2; k < keyframes; ++k)
      for (int keypoint : map.keyframe(k).observed().minus.index)
        if (map.keyframe(k).observed().frame.keypoints[keypoint].response ==
            first.frame.keypoints[m.a].response)
          map.add_sight(track, {k, keypoint});
    const Eigen::Vector3d point =
        scene_pose(0) * Eigen::Vector3d(6 * Eigen::Vector3d(first.x[m.a].homogeneous()));
    map.promote(track, point, Eigen::Matrix3d::Identity());
  }
  return map;
}

}  // namespace eifmap::test
