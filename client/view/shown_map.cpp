#include "client/view/shown_map.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "convert/pose_fields.h"

namespace eifmap {
namespace {

ShownKeyframe shown(const keyframe_t& keyframe) {
  return {read_pose(keyframe.position, keyframe.quaternion)};
}

ShownLandmark shown(const PublishedLandmark& landmark) {
  const landmark_t& value = landmark.value;
  ShownLandmark result;
  result.anchor = value.anchor;
  std::copy(std::begin(value.position), std::end(value.position), result.position.begin());
  result.signed_observations =
      value.laplacian_sign * std::max(1, static_cast<int>(landmark.observations.size()));
  const float variances = value.covariance[0] + value.covariance[3] + value.covariance[5];
  if (std::isfinite(variances)) result.sigma = std::sqrt(std::max(0.0f, variances));
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
  take_over(map.keyframes(), keyframes_, changes.keyframes, changes.removed_keyframes);
  take_over(map.landmarks(), landmarks_, changes.landmarks, changes.removed_landmarks);
  return changes;
}

void ShownMap::clear() {
  keyframes_.clear();
  landmarks_.clear();
}

}  // namespace eifmap
