// A tracked frame's way into the map, at once or beside the frames that come meanwhile.
#include <stdexcept>
#include <string>
#include <utility>

#include "map/keyframe_work.h"
#include "mapper_state.h"

namespace eifmap {

KeyframeJob Mapper::State::make_job(std::shared_ptr<const ObservedFrame> observed,
                                    const Tracking& tracking) {
  auto work = std::make_unique<KeyframeWork>();
  work->id = ++jobs;
  work->map_id = map_id;
  work->stay = stay;
  work->options = options;
  work->observed = std::move(observed);
  work->calibration = calibration;
  work->tracking = tracking;
  work->hardly_seen = live->sight_counts.hardly_seen(live->map());
  work->measurements = desk.take(live->map(), map_id);
  work->before = live->current;
  work->loop_search = live->loop_search;
  work->kept = kept.views();
  work->merge_search = live->merge_search;
  if (!work->kept.empty()) work->view = live->sight_counts.view();
  if (runner && with_updates) work->news = std::move(live->news);
  return KeyframeJob(std::move(work));
}

// The map with the keyframe becomes the map. With a reason it does not: nothing of it was seen.
Reason Mapper::State::adopt(KeyframeJob job) {
  KeyframeWork& work = job.work();
  adopted_job = work.id;
  if (work.news) live->news = std::move(*work.news);
  calibration = std::move(*work.calibration);
  live->full = work.insertion.reason == Reason::kMapFull;
  if (work.insertion.reason != Reason::kNone) {
    desk.put_back(std::move(work.measurements.entries), work.insertion.reason);
    return work.insertion.reason;
  }
  // Where the camera is, seen from its reference, has not changed.
  Rigid3 reference_before = live->map().pose(live->reference);
  if (work.after->is_metric() && !live->map().is_metric()) {
    const double metres_per_unit = work.after->scale().state.metres_per_unit;
    reference_before.translation *= metres_per_unit;
    live->make_metric(metres_per_unit);
    desk.make_metric(metres_per_unit);
  }
  if (!work.loop.growth.empty()) {
    const double here = work.loop.growth[static_cast<std::size_t>(live->reference)];
    live->last.pose.translation =
        reference_before.translation +
        here * (live->last.pose.translation - reference_before.translation);
    live->last.step *= here;
    live->grow(work.loop.growth);
    desk.grow(work.loop.growth);
  }
  if (work.after->epoch() != live->map().epoch() && !work.update) live->news.begin_anew();
  const Rigid3 now_from_before = work.after->pose(live->reference) * reference_before.inverse();
  live->last.pose = now_from_before * live->last.pose;
  live->last.step = now_from_before.rotation * live->last.step;
  if (live->log.newest_is(work.observed->frame.time_us))  // the filter knows better where it was
    live->last.pose = work.after->pose(work.insertion.keyframe);
  live->current = std::move(work.after);
  live->loop_search = std::move(work.loop_search);
  live->merge_search = std::move(work.merge_search);
  count_loop(work.loop);
  live->update = std::move(work.update);
  live->removed_keyframes += work.insertion.removed_keyframes;
  live->removed_landmarks += work.insertion.removed_landmarks;
  nis.add(work.insertion.innovations, live->map().filter().correlation().variance_factor());
  live->most_tracked.push_back(static_cast<int>(work.tracking.sights.size()));
  live->log.make_keyframe(work.observed->frame.time_us, work.insertion.keyframe);
  desk.make_keyframe(work.observed->frame.time_us, work.insertion.keyframe);
  live->reference = work.insertion.keyframe;
  adopt_merge(work);
  map_changed = true;
  return Reason::kNone;
}

void Mapper::State::count_loop(const LoopOutcome& loop) {
  if (!loop.found) return;
  if (!loop.closed())
    ++statistics.loops.refused[loop.reason];
  else if (loop.growth.empty())
    ++statistics.loops.joined;
  else
    ++statistics.loops.closed;
  statistics.loops.last = loop.detail;
}

KeyframeJob Mapper::State::finish_job() {
  job_runs = false;
  try {
    return runner->finish();
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("a keyframe's job: ") + error.what());
  }
}

// What ran beside the frames since it was started. The same at whatever moment between two frames.
void Mapper::State::adopt_beside(FrameResult& result) {
  KeyframeJob job = finish_job();
  if (!live || job.work().stay != stay) {  // of a map that was left
    adopted_job = job.id();
    desk.put_back(std::move(job.work().measurements.entries), Reason::kNone);
    return;
  }
  const std::int64_t time_us = job.work().observed->frame.time_us;
  const Reason reason = adopt(std::move(job));
  if (reason == Reason::kNone || reason == Reason::kMapFull || lost_since_us) return;
  lose(time_us, result);
  ++statistics.reasons[reason];
}

// A map that is full takes a frame as one of many. Now and then it is asked again: elsewhere in the
// map another keyframe may go.
bool Mapper::State::takes_keyframes() {
  constexpr int kAskedAgain = 16;
  return !live->full || ++live->wanted_when_full % kAskedAgain == 0;
}

void Mapper::State::warn_of_bounds(FrameResult& result) const {
  if (!live || result.state != TrackingState::kTracking || result.reason != Reason::kNone) return;
  if (!live->full && live->removed_keyframes + live->removed_landmarks == 0) return;
  result.reason = Reason::kMapFull;
  result.detail = std::to_string(live->removed_keyframes) + " keyframes and " +
                  std::to_string(live->removed_landmarks) + " landmarks have been taken out of " +
                  std::to_string(live->map().num_keyframes_in_use()) + " and " +
                  std::to_string(live->map().num_landmarks());
  if (live->full) result.detail += "; no keyframe more can go, so that none comes";
}

void Mapper::State::add_keyframe(std::shared_ptr<const ObservedFrame> observed,
                                 const Tracking& tracking, FrameResult& result) {
  const Step step(observer, "keyframe");
  const std::int64_t time_us = result.time_us;
  KeyframeJob job = make_job(observed, tracking);
  job.run();
  int keyframe = job.work().insertion.keyframe;
  result.reason = adopt(std::move(job));
  adopted_job = kAdoptedAtOnce;
  if (result.reason == Reason::kMapFull) {
    result.reason = Reason::kNone;
    return add_frame(*observed, tracking, result);
  }
  if (result.reason != Reason::kNone) {
    result.detail = "keyframe " + std::to_string(keyframe) + " with " +
                    std::to_string(tracking.sights.size()) + " map features";
    return lose(time_us, result);
  }
  const Map& map = live->map();
  keyframe = live->reference;  // where two maps have become one it may have another number
  live->log.add(time_us, keyframe, Rigid3());
  desk.add_frame(PlacedFrame::as_keyframe(time_us, keyframe));
  live->last.pose = map.pose(keyframe);
  // The pose as the filter now has it is the better one, and what the frame's users get.
  result.map_from_camera = live->last.pose;
  result.reference_keyframe = keyframe;
  result.reference_from_camera = Rigid3();
  PoseBlock covariance;
  set_covariance(map.filter().pose_covariance(keyframe, covariance), covariance, result);
}

}  // namespace eifmap
