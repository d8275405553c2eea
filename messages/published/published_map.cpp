#include "published/published_map.h"

#include <algorithm>
#include <cmath>

#include "published/map_digest.h"

namespace eifmap {
namespace {

bool is_gone(const observation_t& observation) {
  return std::isnan(observation.u) || std::isnan(observation.v);
}

void cross(const double a[3], const double b[3], double out[3]) {
  for (int i = 0; i < 3; ++i)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

}  // namespace

void PublishedMap::clear() {
  keyframes_.clear();
  landmarks_.clear();
  num_observations_ = 0;
  digest_ = 0;
}

void PublishedMap::apply(const map_part_t& update) {
  if (update.base_seq == -1) clear();
  camera_ = update.camera;
  utime_ = update.utime;
  server_epoch_ = update.server_epoch;
  map_id_ = update.map_id;
  map_epoch_ = update.map_epoch;
  seq_ = update.seq;
  for (const keyframe_t& keyframe : update.keyframes) take(keyframe);
  // What is gone first: a number that is in both is there in the end.
  for (const std::int64_t id : update.removed) remove(id);
  for (const landmark_t& landmark : update.landmarks) take(landmark);
  for (const observation_t& observation : update.observations) take(observation);
}

void PublishedMap::take(const keyframe_t& keyframe) {
  const auto [known, is_new] = keyframes_.try_emplace(keyframe.id);
  if (!is_new) digest_ -= entry_hash(known->second);
  known->second = keyframe;
  digest_ += entry_hash(keyframe);
}

void PublishedMap::take(const landmark_t& landmark) {
  const auto [known, is_new] = landmarks_.try_emplace(landmark.id);
  if (!is_new) digest_ -= entry_hash(known->second.value);
  known->second.value = landmark;
  digest_ += entry_hash(landmark);
}

void PublishedMap::take(const observation_t& observation) {
  const auto landmark = landmarks_.find(observation.landmark);
  if (landmark == landmarks_.end()) return;
  std::vector<observation_t>& list = landmark->second.observations;
  const auto at = std::lower_bound(
      list.begin(), list.end(), observation.keyframe,
      [](const observation_t& o, std::int64_t keyframe) { return o.keyframe < keyframe; });
  const bool known = at != list.end() && at->keyframe == observation.keyframe;
  if (known) {
    digest_ -= entry_hash(*at);
    --num_observations_;
  }
  if (is_gone(observation)) {
    if (known) list.erase(at);
    return;
  }
  digest_ += entry_hash(observation);
  ++num_observations_;
  if (known)
    *at = observation;
  else
    list.insert(at, observation);
}

void PublishedMap::remove(std::int64_t landmark) {
  const auto known = landmarks_.find(landmark);
  if (known == landmarks_.end()) return;
  digest_ -= entry_hash(known->second.value);
  for (const observation_t& observation : known->second.observations)
    digest_ -= entry_hash(observation);
  num_observations_ -= static_cast<std::int64_t>(known->second.observations.size());
  landmarks_.erase(known);
}

map_part_t PublishedMap::whole() const {
  map_part_t update{};
  update.camera = camera_;
  update.utime = utime_;
  update.server_epoch = server_epoch_;
  update.map_id = map_id_;
  update.map_epoch = map_epoch_;
  update.seq = seq_;
  update.base_seq = -1;
  update.digest = digest();
  update.num_parts = 1;
  for (const auto& [id, keyframe] : keyframes_) update.keyframes.push_back(keyframe);
  for (const auto& [id, landmark] : landmarks_) {
    update.landmarks.push_back(landmark.value);
    update.observations.insert(update.observations.end(), landmark.observations.begin(),
                               landmark.observations.end());
  }
  update.num_keyframes = static_cast<std::int32_t>(update.keyframes.size());
  update.num_landmarks = static_cast<std::int32_t>(update.landmarks.size());
  update.num_removed = 0;
  update.num_observations = static_cast<std::int32_t>(update.observations.size());
  return update;
}

std::size_t PublishedMap::whole_bytes() const {
  static const auto of_keyframe = static_cast<std::size_t>(keyframe_t{}._getEncodedSizeNoHash());
  static const auto of_landmark = static_cast<std::size_t>(landmark_t{}._getEncodedSizeNoHash());
  static const auto of_observation =
      static_cast<std::size_t>(observation_t{}._getEncodedSizeNoHash());
  return of_keyframe * keyframes_.size() + of_landmark * landmarks_.size() +
         of_observation * static_cast<std::size_t>(num_observations_);
}

bool position_in_map(const PublishedMap& map, const landmark_t& landmark, double position[3]) {
  const auto anchor = map.keyframes().find(landmark.anchor);
  if (anchor == map.keyframes().end()) return false;
  const keyframe_t& k = anchor->second;
  // Of a unit quaternion: p + 2 w (v x p) + 2 v x (v x p).
  const double p[3] = {landmark.position[0], landmark.position[1], landmark.position[2]};
  const double* v = k.quaternion + 1;
  double once[3], twice[3];
  cross(v, p, once);
  cross(v, once, twice);
  for (int i = 0; i < 3; ++i)
    position[i] = k.position[i] + p[i] + 2 * (k.quaternion[0] * once[i] + twice[i]);
  return true;
}

}  // namespace eifmap
