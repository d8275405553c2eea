// A frame's pose: the start of a map, tracking, lost and found again.
#include <algorithm>
#include <utility>
#include <vector>

#include "map/frame_covariance.h"
#include "map/image_shift.h"
#include "map/keyframe_insertion.h"
#include "map/moving_matches.h"
#include "mapper_state.h"

namespace eifmap {
namespace {

// As the desk for measurements wants it.
PlacedFrame placed_frame(const Map& map, const Tracking& tracking, const FrameResult& result) {
  const Eigen::Matrix3d to_keyframe = map.pose(tracking.reference).matrix().transpose();
  const Eigen::Matrix3d of_centre =
      to_keyframe * tracking.covariance.bottomRightCorner<3, 3>() * to_keyframe.transpose();
  return {result.time_us, tracking.reference, result.reference_from_camera,
          tracking.covariance.topLeftCorner<3, 3>().cast<float>(), of_centre.cast<float>()};
}

}  // namespace

// [WD10] IV: the first images.
void Mapper::State::start_map(ObservedFrame observed, FrameResult& result) {
  if (localize_only) {
    result.reason = Reason::kNotRelocalized;
    result.detail = "there is no map, and none is to be made";
    return;
  }
  const Step step(observer, "start");
  const std::int64_t time_us = observed.frame.time_us;
  StartStep begun = start.add(std::move(observed));
  result.reason = begun.reason;
  result.detail = std::move(begun.detail);
  result.num_matches = begun.num_matches;
  if (!begun.started) {
    if (!live) result.state = TrackingState::kStarting;
    return;
  }
  const std::int64_t next_epoch = live ? epoch() + 1 : first_epoch;
  leave_map();
  live.emplace(std::move(begun.started->map), camera);
  begin_epoch(next_epoch);
  map_sign = live->map().map_sign();
  map_id = ++last_map_id;
  ++statistics.starts;
  lost_since_us.reset();
  for (const TimedPose& posed : begun.started->posed)
    live->log.add(posed.time_us, 0, live->map().pose(0).inverse() * posed.world_from_camera);
  live->log.add(time_us, 1, Rigid3());
  desk.forget_frames();
  desk.add_frame(PlacedFrame::as_keyframe(live->map().keyframe(0).time_us, 0));
  desk.add_frame(PlacedFrame::as_keyframe(time_us, 1));
  live->reference = 1;
  live->last = {live->map().pose(1)};
  result.state = TrackingState::kTracking;
  result.source = PoseSource::kStartSet;
  result.map_from_camera = live->last.pose;
  result.reference_keyframe = 1;
  result.num_inliers = live->map().num_landmarks();
  map_changed = true;
  PoseBlock covariance;
  set_covariance(live->map().filter().pose_covariance(1, covariance), covariance, result);
}

// Never zero or identity for unknown: kNone says so. A filter that keeps its first linearization
// is known to be too sure of itself.
void Mapper::State::set_covariance(bool known, const PoseBlock& covariance,
                                   FrameResult& result) const {
  result.covariance_status = CovarianceStatus::kNone;
  result.covariance.setZero();
  if (!known) return;
  result.covariance = centre_first(covariance);
  result.covariance_status = options.filter.relinearize == Relinearize::kOnce
                                 ? CovarianceStatus::kOptimistic
                                 : CovarianceStatus::kValid;
}

void Mapper::State::lose(std::int64_t time_us, FrameResult& result) {
  lost_since_us = time_us;
  may_go_on = false;
  ++statistics.losses;
  start.reset();
  result.state = TrackingState::kLost;
  result.source = PoseSource::kNone;
  result.covariance_status = CovarianceStatus::kNone;
}

// [WD10] IV: the first keyframes may be posed by plain triangulation.
MapperOptions Mapper::State::tracking_options() const {
  MapperOptions now = options;
  if (live->map().num_keyframes() < 2 + options.start.triangulated_keyframes)
    now.tracking.start = PoseStart::kTriangulation;
  return now;
}

Tracking Mapper::State::try_track(const ObservedFrame& observed) {
  const Step step(observer, "track");
  return track_frame(live->map(), observed, live->reference, live->last, tracking_options());
}

void Mapper::State::track(ObservedFrame observed, FrameResult& result) {
  Tracking tracking = try_track(observed);
  // The keyframe in work may show what the map so far does not: late is better than lost. From here
  // on all is as if it had been adopted before the frame, which is what the decisions say.
  if (!tracking.ok() && job_runs) {
    adopt_beside(result);
    if (lost_since_us) return find_again(std::move(observed), result);
    tracking = try_track(observed);
  }
  if (tracking.ok()) return accept(std::move(observed), tracking, result);
  lose(observed.frame.time_us, result);
  may_go_on = tracking.reason != Reason::kAmbiguousPlace;
  result.reason = tracking.reason;
  result.detail = std::move(tracking.detail);
  result.num_matches = tracking.num_matches;
}

// A few spoilt images must not cost the good one after them. As certain as after a relocalization.
Tracking Mapper::State::try_to_go_on(const ObservedFrame& observed) {
  const double lost_s = 1e-6 * static_cast<double>(observed.frame.time_us - *lost_since_us);
  Tracking tracking;
  if (!may_go_on || lost_s >= options.lost.new_map_after_s) return tracking;
  const Step step(observer, "track");
  tracking = track_frame(live->map(), observed, live->reference, {live->last.pose, {0, 0, 0}},
                         tracking_options(), 0);
  if (static_cast<int>(tracking.sights.size()) < options.lost.min_inliers)
    tracking.reason = Reason::kTooFewInliers;
  return tracking;
}

Tracking Mapper::State::try_relocalize(const ObservedFrame& observed) {
  const Step step(observer, "relocalize");
  // Where the camera was lost, and the newest.
  constexpr int kNear = 3, kNewest = 2;
  const Map& map = live->map();
  std::vector<int> likely = map.covisible(live->reference, kNear);
  for (int k = map.num_keyframes() - 1, found = 0; k >= 0 && found < kNewest; --k)
    if (!map.is_removed(k)) likely.push_back(k), ++found;
  return relocalize(map, observed,
                    keyframes_to_try(*live, observed.frame, options.lost.places, likely), options);
}

void Mapper::State::find_again(ObservedFrame observed, FrameResult& result) {
  Tracking tracking = try_to_go_on(observed);
  if (!tracking.ok()) tracking = try_relocalize(observed);
  // Where the camera may be in another map this one must be the better word for what it sees.
  if (tracking.source == PoseSource::kRelocalized && kept.size() > 0) {
    check_seen(*live, observed, tracking);
    if (tracking.ok() && !is_only_there(tracking, map_id, observed.frame))
      tracking.reason = Reason::kAmbiguousPlace;
  }
  if (tracking.ok()) {
    lost_since_us.reset();
    seen_in.reset();
    start.reset();
    return accept(std::move(observed), tracking, result);
  }
  if (find_in_kept(observed, result)) return;
  result.state = TrackingState::kLost;
  const double lost_s = 1e-6 * static_cast<double>(observed.frame.time_us - *lost_since_us);
  if (!localize_only && lost_s >= options.lost.new_map_after_s && !seen_in)
    start_map(std::move(observed), result);
  if (result.state != TrackingState::kLost) return;
  if (!result.detail.empty()) tracking.detail += "; a new map waits: " + result.detail;
  result.reason = tracking.reason;
  result.detail = std::move(tracking.detail);
}

void Mapper::State::accept(ObservedFrame observed, const Tracking& tracking, FrameResult& result) {
  const Map& map = live->map();
  const bool continued = tracking.source != PoseSource::kRelocalized;
  const Eigen::Vector3d step = tracking.world_from_camera.translation - live->last.pose.translation;
  const Eigen::Vector2d step_px =
      median_step(map, tracking.sights, live->last.pose, tracking.world_from_camera) /
      map.radians_per_pixel();
  live->last = {tracking.world_from_camera, continued ? step : Eigen::Vector3d::Zero()};
  live->reference = better_reference(map, tracking);
  int& most_tracked = live->most_tracked[static_cast<std::size_t>(tracking.reference)];
  most_tracked = std::max(most_tracked, static_cast<int>(tracking.sights.size()));
  result.state = TrackingState::kTracking;
  result.source = tracking.source;
  result.map_from_camera = tracking.world_from_camera;
  result.reference_keyframe = tracking.reference;
  result.reference_from_camera =
      map.pose(tracking.reference).inverse() * tracking.world_from_camera;
  result.num_matches = tracking.num_matches;
  result.num_inliers = static_cast<int>(tracking.sights.size());
  result.num_moving = count_moving_matches(map, observed, tracking);
  const auto shared = std::make_shared<const ObservedFrame>(std::move(observed));
  const Usual usual{most_tracked, live->history.is_odd_step(step_px)};
  live->history.add(step_px);
  live->sight_counts.add(map, tracking);
  const bool as_keyframe = !localize_only && !job_runs &&
                           wants_keyframe(map, tracking, usual, options) && takes_keyframes();
  if (as_keyframe && !runner) return add_keyframe(shared, tracking, result);
  add_frame(*shared, tracking, result);
  if (as_keyframe) {
    runner->start(make_job(shared, tracking));
    job_runs = true;
  }
}

// One that is no keyframe.
void Mapper::State::add_frame(const ObservedFrame& observed, const Tracking& tracking,
                              FrameResult& result) {
  PoseBlock covariance;
  const bool known =
      frame_covariance(live->map(), observed, tracking, options.absolute_pose, covariance);
  set_covariance(known, covariance, result);
  live->log.add(result.time_us, tracking.reference, result.reference_from_camera);
  desk.add_frame(placed_frame(live->map(), tracking, result));
}

}  // namespace eifmap
