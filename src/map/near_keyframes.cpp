#include "map/near_keyframes.h"

#include <algorithm>
#include <utility>

namespace eifmap {

std::vector<int> near_keyframes(const Map& map, const Rigid3& world_from_camera, double depth,
                                int count, const std::vector<int>& but) {
  constexpr double kDistance = 0.25, kAngle = 0.3;  // of the depth; rad
  std::vector<std::pair<double, int>> near;         // how far, and which
  for (int k = 0; k < map.num_keyframes(); ++k) {
    if (map.is_removed(k)) continue;
    const Rigid3& pose = map.pose(k);
    const double distance = (pose.translation - world_from_camera.translation).norm();
    if (!(distance <= kDistance * depth)) continue;
    const double angle = pose.rotation.angularDistance(world_from_camera.rotation);
    if (angle > kAngle || std::find(but.begin(), but.end(), k) != but.end()) continue;
    const double relative = distance / depth;
    near.emplace_back(relative * relative + angle * angle, k);
  }
  std::sort(near.begin(), near.end());
  if (static_cast<int>(near.size()) > count) near.resize(count);
  std::vector<int> keyframes;
  for (const auto& [how_far, k] : near) keyframes.push_back(k);
  return keyframes;
}

std::vector<int> num_seen(const Map& map, const std::vector<LandmarkSight>& sights) {
  std::vector<int> seen(map.num_keyframes(), 0);
  for (const LandmarkSight& sight : sights)
    for (const Sight& s : map.track(sight.track).sights) ++seen[s.keyframe];
  return seen;
}

}  // namespace eifmap
