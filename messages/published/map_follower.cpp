#include "published/map_follower.h"

#include <algorithm>
#include <iterator>

namespace eifmap {

bool MapFollower::Pending::is_complete() const {
  return !parts.empty() &&
         parts.size() == static_cast<std::size_t>(parts.begin()->second.num_parts);
}

bool MapFollower::Pending::agrees(const map_part_t& part) const {
  if (parts.empty()) return true;
  const map_part_t& other = parts.begin()->second;
  return part.num_parts == other.num_parts && part.digest == other.digest &&
         part.map_id == other.map_id && part.map_epoch == other.map_epoch;
}

map_part_t MapFollower::Pending::update() const {
  map_part_t update = parts.begin()->second;
  for (auto part = std::next(parts.begin()); part != parts.end(); ++part)
    append(part->second, update);
  return update;
}

// False when it is of an older run.
bool MapFollower::take_run(std::int64_t server_epoch, TimePoint now) {
  if (server_epoch < server_epoch_) return false;
  if (server_epoch == server_epoch_) return true;
  server_epoch_ = server_epoch;
  heard_seq_ = 0;
  is_right_ = false;
  pending_.clear();
  note_progress(now);
  return true;
}

bool MapFollower::is_stale() const {
  return is_right_ ? heard_seq_ > map_.seq() : heard_seq_ > 0 || map_.seq() > 0;
}

// Updates from the map on, and whole maps that are newer.
bool MapFollower::is_of_use(const Step& step) const {
  return !is_right_ || step.seq > map_.seq();
}

bool MapFollower::is_next(const Step& step) const {
  return step.is_whole() ? is_of_use(step) : is_right_ && step.base == map_.seq();
}

void MapFollower::note_progress(TimePoint now) {
  patience_ = kPatience;
  next_ask_ = now + patience_;
}

void MapFollower::hear(const std::string& camera, std::int64_t server_epoch, std::int64_t map_seq,
                       TimePoint now, std::optional<std::int64_t> digest) {
  if (!take_run(server_epoch, now)) return;
  camera_ = camera;
  const bool was_stale = is_stale();
  heard_seq_ = std::max(heard_seq_, map_seq);
  if (digest && is_right_ && map_seq == map_.seq() && *digest != map_.digest()) {
    ++counts_.wrong_digests;
    is_right_ = false;
  }
  if (!was_stale && is_stale()) note_progress(now);
}

MapFollower::Outcome MapFollower::take(const map_part_t& part, TimePoint now) {
  hear(part.camera, part.server_epoch, part.seq, now);
  const Step step{part.seq, part.base_seq};
  if (part.server_epoch != server_epoch_ || !is_of_use(step)) return Outcome::kIgnored;

  Pending& pending = pending_[step];
  if (!pending.agrees(part)) {
    ++counts_.contradictions;
    return Outcome::kIgnored;
  }
  if (!pending.parts.emplace(part.part, part).second) return Outcome::kIgnored;
  if (is_next(step)) note_progress(now);
  const bool applied = pending.is_complete() && apply_ready(now);
  make_room();
  return applied ? Outcome::kApplied : Outcome::kIncomplete;
}

// Applies what is whole and follows on from the map, the furthest first, until there is none.
bool MapFollower::apply_ready(TimePoint now) {
  bool applied = false;
  for (;;) {
    const auto next = std::find_if(pending_.rbegin(), pending_.rend(), [this](const auto& entry) {
      return entry.second.is_complete() && is_next(entry.first);
    });
    if (next == pending_.rend()) return applied;
    apply(next->second.update());
    std::erase_if(pending_, [this](const auto& entry) { return entry.first.seq <= map_.seq(); });
    if (is_right_) note_progress(now);
    applied = true;
  }
}

void MapFollower::note_changes(const map_part_t& update) {
  if (update.base_seq == -1) {
    changes_ = {};
    changes_.whole = true;
  }
  for (const keyframe_t& keyframe : update.keyframes) changes_.keyframes.push_back(keyframe.id);
  for (const landmark_t& landmark : update.landmarks) changes_.landmarks.push_back(landmark.id);
  for (const observation_t& seen : update.observations) changes_.landmarks.push_back(seen.landmark);
  changes_.removed_landmarks.insert(changes_.removed_landmarks.end(), update.removed.begin(),
                                    update.removed.end());
}

void MapFollower::apply(const map_part_t& update) {
  map_.apply(update);
  note_changes(update);
  ++counts_.updates;
  counts_.whole_maps += update.base_seq == -1 ? 1 : 0;
  is_right_ = map_.digest() == update.digest;
  counts_.wrong_digests += is_right_ ? 0 : 1;
}

void MapFollower::make_room() {
  drop_old_wholes();
  while (pending_.size() > kMaxWaiting) {
    auto last = std::prev(pending_.end());
    while (last != pending_.begin() && last->first.is_whole()) --last;
    pending_.erase(last);
  }
}

void MapFollower::drop_old_wholes() {
  int wholes = 0;
  for (auto entry = pending_.end(); entry != pending_.begin();) {
    --entry;
    if (entry->first.is_whole() && ++wholes > kMaxWholes) entry = pending_.erase(entry);
  }
}

const MapFollower::Pending* MapFollower::pending(const Step& step) const {
  const auto found = pending_.find(step);
  return found == pending_.end() ? nullptr : &found->second;
}

std::optional<MapFollower::Step> MapFollower::newest_whole() const {
  const auto found = std::find_if(pending_.rbegin(), pending_.rend(), [this](const auto& entry) {
    return entry.first.is_whole() && is_of_use(entry.first);
  });
  return found == pending_.rend() ? std::nullopt : std::optional(found->first);
}

void MapFollower::add_missing(const Step& step, map_request_t& request) const {
  const auto add = [&](std::int32_t part) {
    if (request.missing.size() == kMaxMissing) return;
    missing_part_t missing;
    missing.seq = step.seq;
    missing.part = part;
    missing.whole = step.is_whole() ? 1 : 0;
    request.missing.push_back(missing);
  };
  const Pending* known = pending(step);
  if (!known) return add(kAllParts);
  const std::int32_t parts = known->parts.begin()->second.num_parts;
  for (std::int32_t i = 0; i < parts; ++i)
    if (!known->parts.contains(i)) add(i);
}

// Steps from the map on are asked for by preference. Where the server has answered that with a
// whole map, since it has them no more, it is the whole map that must become whole.
bool MapFollower::goes_by_whole() const {
  if (!is_right_) return true;
  const Step first{map_.seq() + 1, map_.seq()};
  return asked_from_ == map_.seq() && !pending(first);
}

std::optional<map_request_t> MapFollower::ask(TimePoint now, std::int64_t utime) {
  if (!is_stale() || heard_seq_ == 0 || now < next_ask_) return std::nullopt;
  map_request_t request{};
  request.utime = utime;
  request.requester = requester_;
  request.request_id = ++counts_.requests;
  request.camera = camera_;
  request.server_epoch = is_right_ ? server_epoch_ : 0;
  request.have_seq = is_right_ ? map_.seq() : -1;
  const auto whole = goes_by_whole() ? newest_whole() : std::nullopt;
  if (whole) add_missing(*whole, request);
  if (whole || is_right_)
    for (std::int64_t seq = whole ? whole->seq + 1 : map_.seq() + 1;
         seq <= heard_seq_ && request.missing.size() < kMaxMissing; ++seq) {
      const bool came_whole = !pending({seq, seq - 1}) && pending({seq, -1});
      add_missing({seq, came_whole ? -1 : seq - 1}, request);
    }
  asked_from_ = is_right_ ? map_.seq() : -1;
  request.num_missing = static_cast<std::int32_t>(request.missing.size());
  next_ask_ = now + patience_;
  patience_ = std::min<std::chrono::milliseconds>(2 * patience_, kMaxPatience);
  return request;
}

}  // namespace eifmap
