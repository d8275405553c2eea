// A mapper's maps out of it, and into another one.
#include <stdexcept>
#include <utility>

#include "map/map_snapshot.h"
#include "mapper_state.h"

namespace eifmap {
namespace {

MapSnapshot snapshot_of(std::int64_t map_id, std::int64_t epoch, const LiveMap& live) {
  MapSnapshot snapshot;
  snapshot.map_id = map_id;
  snapshot.epoch = epoch;
  snapshot.map = live.current;
  snapshot.log = live.log;
  snapshot.most_tracked = live.most_tracked;
  snapshot.removed_keyframes = live.removed_keyframes;
  snapshot.removed_landmarks = live.removed_landmarks;
  snapshot.reference = live.reference;
  return snapshot;
}

// A copy of the map, which shares what is never written to.
LiveMap live_of(const MapSnapshot& snapshot, const Camera& camera) {
  LiveMap live(*snapshot.map, camera);
  live.log = snapshot.log;
  live.most_tracked = snapshot.most_tracked;
  live.removed_keyframes = snapshot.removed_keyframes;
  live.removed_landmarks = snapshot.removed_landmarks;
  live.reference = snapshot.reference;
  live.last = {live.map().pose(snapshot.reference)};
  return live;
}

}  // namespace

MapperSnapshot Mapper::snapshot() const {
  MapperSnapshot snapshot;
  snapshot.last_map_id = state_->last_map_id;
  if (state_->live) snapshot.in_use = snapshot_of(state_->map_id, state_->epoch(), *state_->live);
  for (const KeptMap& map : state_->kept.all())
    snapshot.kept.push_back(snapshot_of(map.map_id, map.epoch, map.live));
  return snapshot;
}

void Mapper::restore(const MapperSnapshot& snapshot) {
  State& state = *state_;
  if (state.last_time_us || state.live || state.kept.size() > 0)
    throw std::invalid_argument("Mapper::restore: it has begun already");
  for (const MapSnapshot& map : snapshot.kept)
    state.kept.keep({map.map_id, live_of(map, state.camera), map.epoch, {}});
  state.last_map_id = snapshot.last_map_id;
  state.first_epoch = snapshot.next_epoch;
  if (!snapshot.in_use) return;
  state.live.emplace(live_of(*snapshot.in_use, state.camera));
  state.map_id = snapshot.in_use->map_id;
  state.map_sign = state.live->map().map_sign();
  const FeatureFrame& seen =
      state.live->map().keyframe(state.live->map().newest()).observed().frame;
  state.extractor = {seen.extractor, seen.extractor_version};
  state.begin_epoch(snapshot.in_use->epoch);
  state.map_changed = true;
  state.count_map();
}

void Mapper::localize_only(bool only) {
  state_->localize_only = only;
}

bool Mapper::localizes_only() const {
  return state_->localize_only;
}

// The first frame of a mapper whose maps were made before it.
void Mapper::State::begin_where_it_was(std::int64_t time_us) {
  lost_since_us = time_us;
  may_go_on = false;
}

}  // namespace eifmap
