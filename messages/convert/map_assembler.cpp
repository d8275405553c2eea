#include "convert/map_assembler.h"

#include <algorithm>
#include <tuple>

namespace eifmap {
namespace {

template <class Entry>
void append(std::vector<Entry>& to, const std::vector<Entry>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

std::vector<MapPoint> PublishedMap::points() const {
  std::vector<MapPoint> points;
  points.reserve(landmarks.size());
  for (const auto& [id, landmark] : landmarks) {
    const auto anchor = keyframes.find(landmark.anchor);
    if (anchor == keyframes.end()) continue;
    points.push_back({anchor->second.map_from_camera * landmark.position_in_anchor,
                      landmark.laplacian_sign, landmark.num_observations});
  }
  return points;
}

// False when the part is of an older run of the server or of a map that was in use before this one.
// A map that is in use again has a lower id than the last, and a greater epoch.
bool MapAssembler::take_map(const MapPart& part) {
  const std::int64_t server_epoch = part.origin.server_epoch;
  const auto& [map_id, map_epoch] = std::tie(part.update.map_id, part.update.map_epoch);
  if (server_epoch == map_.server_epoch && map_id == map_.map_id) {
    newest_epoch_ = std::max(newest_epoch_, map_epoch);
    return true;
  }
  if (std::tie(server_epoch, map_epoch, map_id) <
      std::tie(map_.server_epoch, newest_epoch_, map_.map_id))
    return false;
  map_ = {};
  map_.server_epoch = server_epoch;
  map_.map_id = map_id;
  map_.map_epoch = newest_epoch_ = map_epoch;
  pending_.clear();
  lost_ = 0;
  return true;
}

MapAssembler::Outcome MapAssembler::add(const MapPart& part) {
  if (!take_map(part) || part.update.seq <= map_.seq) return Outcome::kIgnored;
  Pending& pending = pending_[part.update.seq];
  if (pending.have.empty()) {
    pending.update.map_id = part.update.map_id;
    pending.update.map_epoch = part.update.map_epoch;
    pending.update.seq = part.update.seq;
    pending.update.base_seq = part.update.base_seq;
    pending.have.resize(static_cast<std::size_t>(part.num_parts));
    pending.missing = pending.have.size();
  }
  const auto index = static_cast<std::size_t>(part.part);
  if (pending.have.size() != static_cast<std::size_t>(part.num_parts) || pending.have[index] ||
      pending.update.base_seq != part.update.base_seq)
    return Outcome::kIgnored;
  pending.have[index] = true;
  --pending.missing;
  append(pending.update.keyframes, part.update.keyframes);
  append(pending.update.landmarks, part.update.landmarks);
  append(pending.update.removed_landmarks, part.update.removed_landmarks);
  append(pending.update.observations, part.update.observations);

  const bool whole = pending.missing == 0;
  const std::int64_t seq = part.update.seq;
  if (whole && apply_ready() && map_.seq >= seq) return Outcome::kApplied;
  if (pending_.size() > max_waiting_) skip_gap();
  if (map_.seq >= seq) return Outcome::kApplied;
  return whole ? Outcome::kWaiting : Outcome::kIncomplete;
}

bool MapAssembler::is_next(const Pending& pending) const {
  return pending.missing == 0 &&
         (pending.update.base_seq == -1 || pending.update.base_seq == map_.seq);
}

// Applies every whole update that follows on from the map.
bool MapAssembler::apply_ready() {
  bool applied = false;
  for (;;) {
    const auto next = std::find_if(pending_.begin(), pending_.end(),
                                   [this](const auto& entry) { return is_next(entry.second); });
    if (next == pending_.end()) return applied;
    apply(next->second.update);
    pending_.erase(pending_.begin(), std::next(next));  // what is older is contained in it
    applied = true;
  }
}

void MapAssembler::apply(const MapUpdate& update) {
  // Of another epoch: what was before is in another unit, also where the whole map was lost.
  if (update.base_seq == -1 || update.map_epoch != map_.map_epoch) {
    map_.keyframes.clear();
    map_.landmarks.clear();
    map_.observed.clear();
  }
  for (const KeyframeView& keyframe : update.keyframes) map_.keyframes[keyframe.id] = keyframe;
  for (const LandmarkView& landmark : update.landmarks) map_.landmarks[landmark.id] = landmark;
  for (const ObservationView& o : update.observations)
    map_.observed.emplace(o.keyframe, o.landmark);
  for (const std::int64_t id : update.removed_landmarks) map_.landmarks.erase(id);
  map_.map_epoch = update.map_epoch;
  map_.seq = update.seq;
}

// Gives up what is missing before the oldest whole update; when none is whole, the oldest itself.
void MapAssembler::skip_gap() {
  const auto whole = std::find_if(pending_.begin(), pending_.end(),
                                  [](const auto& entry) { return entry.second.missing == 0; });
  ++lost_;
  if (whole == pending_.end()) {
    pending_.erase(pending_.begin());
    return;
  }
  lost_ += std::distance(pending_.begin(), whole);
  apply(whole->second.update);
  pending_.erase(pending_.begin(), std::next(whole));
  apply_ready();
}

void MapAssembler::finish() {
  while (!pending_.empty()) skip_gap();
}

}  // namespace eifmap
