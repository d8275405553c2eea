#include "client/view/shown_map.h"

#include <algorithm>
#include <cmath>

namespace eifmap {
namespace {

ShownKeyframe shown(const KeyframeView& keyframe) {
  return {keyframe.map_from_camera};
}

ShownLandmark shown(const LandmarkView& landmark) {
  ShownLandmark result;
  result.anchor = landmark.anchor;
  for (int i = 0; i < 3; ++i)
    result.position[static_cast<std::size_t>(i)] =
        static_cast<float>(landmark.position_in_anchor[i]);
  result.signed_observations = landmark.laplacian_sign * std::max(1, landmark.num_observations);
  if (landmark.covariance.allFinite())
    result.sigma = static_cast<float>(std::sqrt(std::max(0.0, landmark.covariance.trace())));
  return result;
}

// Both are sorted by id: one walk over the two together.
template <class View, class Shown>
void take_over(const std::map<std::int64_t, View>& from, std::map<std::int64_t, Shown>& to,
               std::vector<std::pair<std::int64_t, Shown>>& changed,
               std::vector<std::int64_t>& removed) {
  auto old = to.begin();
  const auto remove_old = [&] {
    removed.push_back(old->first);
    old = to.erase(old);
  };
  for (const auto& [id, view] : from) {
    while (old != to.end() && old->first < id) remove_old();
    const Shown now = shown(view);
    const bool known = old != to.end() && old->first == id;
    if (!known || !(old->second == now)) changed.emplace_back(id, now);
    if (known)
      (old++)->second = now;
    else
      to.emplace_hint(old, id, now);
  }
  while (old != to.end()) remove_old();
}

}  // namespace

bool ShownKeyframe::operator==(const ShownKeyframe& other) const {
  return map_from_camera.translation == other.map_from_camera.translation &&
         map_from_camera.rotation.coeffs() == other.map_from_camera.rotation.coeffs();
}

MapChanges ShownMap::update(const PublishedMap& map) {
  MapChanges changes;
  take_over(map.keyframes, keyframes_, changes.keyframes, changes.removed_keyframes);
  take_over(map.landmarks, landmarks_, changes.landmarks, changes.removed_landmarks);
  return changes;
}

void ShownMap::clear() {
  keyframes_.clear();
  landmarks_.clear();
}

}  // namespace eifmap
