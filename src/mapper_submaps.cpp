// Maps that are left, come back to, and become one.
#include <utility>
#include <vector>

#include "map/keyframe_work.h"
#include "map/other_place.h"
#include "map/share_seen.h"
#include "mapper_state.h"

namespace eifmap {
// The map in use is another one, or has become one with another.
void Mapper::State::begin_epoch(std::int64_t epoch) {
  epoch_before = epoch - live->map().epoch();
  ++stay;
}

// Kept. What has to go for it is given up, but for the largest one's trajectory.
void Mapper::State::leave_map() {
  if (!live) return;
  live->update.reset();
  live->loop_search.begin_anew();
  live->merge_search.begin_anew();
  const std::int64_t epoch_now = epoch();
  std::optional<KeptMap> gone = kept.keep(
      {map_id, std::move(*live), epoch_now, desk.change_frames(std::deque<PlacedFrame>())});
  live.reset();
  if (!gone) return;
  measured_before += gone->live.map().scale().counts;
  FinishedMap old = finish(gone->live);
  if (!finished || old.trajectory.size() > finished->trajectory.size()) finished = std::move(old);
}

// Of a place that only has something in common with where the camera is, the rest is not seen.
void Mapper::State::check_seen(const LiveMap& there, const ObservedFrame& observed,
                               Tracking& tracking) const {
  if (!tracking.ok()) return;
  const SeenAgain seen = seen_again(there.map(), tracking.reference, observed,
                                    tracking.world_from_camera, there.sight_counts.view(), options);
  if (seen.is_all_over(options.lost)) return;
  tracking.reason = Reason::kNotRelocalized;
  tracking.detail = seen.in_words();
  tracking.source = PoseSource::kNone;
}

// `observed`: the frame as that map has it.
Tracking Mapper::State::find_in(LiveMap& there, const FeatureFrame& frame,
                                ObservedFrame& observed) const {
  const Map& map = there.map();
  observed = observe(frame, camera, map.map_sign(), map.sigma_factor());
  return relocalize(map, observed, keyframes_to_try(there, observed.frame, options.lost.places, {}),
                    options);
}

// Whether no other map explains the image about as well.
bool Mapper::State::is_only_there(const Tracking& found, std::int64_t found_in,
                                  const FeatureFrame& frame) {
  const Step step(observer, "relocalize");
  const int agree = static_cast<int>(found.sights.size());
  const auto explains = [&](LiveMap& there) {
    ObservedFrame observed;
    const Tracking other = find_in(there, frame, observed);
    return other.ok() &&
           choose_place(agree, static_cast<int>(other.sights.size())) != PlaceChoice::kFar;
  };
  if (map_id != found_in && explains(*live)) return false;
  for (KeptMap& map : kept.all())
    if (map.map_id != found_in && explains(map.live)) return false;
  return true;
}

// A lost camera in one kept map, another with each image. Believed when two images in a row say so,
// see of the map what they should, and no other map says the same: true, and it is accepted there.
bool Mapper::State::find_in_kept(const ObservedFrame& observed, FrameResult& result) {
  const std::optional<std::int64_t> seen_before = std::exchange(seen_in, std::nullopt);
  KeptMap* there = seen_before ? kept.find(*seen_before) : kept.next_to_try();
  if (!there) return false;
  Tracking tracking;
  ObservedFrame again;
  {
    const Step step(observer, "relocalize");
    tracking = find_in(there->live, observed.frame, again);
    check_seen(there->live, again, tracking);
  }
  if (!tracking.ok()) return false;
  const std::int64_t found_in = there->map_id;
  if (seen_before != found_in) {
    seen_in = found_in;
    return false;
  }
  if (!is_only_there(tracking, found_in, observed.frame)) return false;
  return_to(found_in, std::move(again), tracking, result);
  return true;
}

void Mapper::State::return_to(std::int64_t kept_map, ObservedFrame observed,
                              const Tracking& tracking, FrameResult& result) {
  const std::int64_t next_epoch = epoch() + 1;
  KeptMap back = kept.take(kept_map);
  leave_map();
  live = std::move(back.live);
  map_id = back.map_id;
  map_sign = live->map().map_sign();
  desk.change_frames(std::move(back.frames));
  live->news.begin_anew();
  live->sight_counts.forget_last();
  begin_epoch(next_epoch);
  lost_since_us.reset();
  start.reset();
  ++statistics.submaps.returned;
  map_changed = true;
  accept(std::move(observed), tracking, result);
}

// What the keyframe's job has found of the kept maps. All that is said relative to a keyframe stays
// as it is, in the unit and with the numbers of the map that is left of the two.
void Mapper::State::adopt_merge(KeyframeWork& work) {
  const MergeOutcome& merge = work.merge;
  if (!merge.found) return;
  statistics.submaps.last = merge.detail;
  if (!merge.merged) {
    ++statistics.submaps.refused[merge.reason];
    return;
  }
  ++statistics.submaps.merged;
  const std::int64_t next_epoch = epoch() + 1;
  KeptMap other = kept.take(merge.map_id);
  const Rigid3 before = live->map().pose(live->reference);
  Rigid3 in_reference = before.inverse() * live->last.pose;
  Eigen::Vector3d step = before.rotation.conjugate() * live->last.step;
  desk.include(other.frames, merge.appended, merge.into_kept);
  if (merge.into_kept) {
    in_reference.translation *= merge.appended.growth;
    step *= merge.appended.growth;
    other.live.include(*live, merge.appended, true);
    other.live.follow(std::move(*live), merge.appended);
    live = std::move(other.live);
    map_id = other.map_id;
  } else {
    live->include(other.live, merge.appended, false);
  }
  live->full = false;
  live->current = merge.merged;
  const Rigid3& now = live->map().pose(live->reference);
  live->last = {now * in_reference, now.rotation * step};
  if (!work.update) live->news.begin_anew();
  begin_epoch(next_epoch);
}

}  // namespace eifmap
