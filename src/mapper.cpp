#include "mapper.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "map/asked_views.h"
#include "map/audit.h"
#include "mapper_state.h"

namespace eifmap {

// A publisher that was started again, or times that stay behind: one wild time stamp, or a
// recording published twice, must not lock the input.
bool Mapper::State::begins_stream(std::int64_t of_publisher) const {
  return (publisher != 0 && of_publisher != 0 && of_publisher != publisher) ||
         old_times >= kPatience;
}

bool Mapper::State::is_late(std::int64_t of_publisher, std::int64_t time_us) const {
  return last_time_us && time_us <= *last_time_us && !begins_stream(of_publisher);
}

// What was mapped stays; where the camera is now, nobody knows.
void Mapper::State::begin_stream(const FeatureFrame& frame) {
  last_time_us.reset();
  start.reset();
  desk.forget_frames();
  kept.forget_frames();
  seen_in.reset();
  if (live)
    lost_since_us = frame.time_us, may_go_on = false;
  else
    extractor.reset();
}

FrameCheck Mapper::State::check(const FeatureFrame& frame) {
  FrameCheck result = check_frame(frame, camera);
  if (!result.ok()) return result;
  if (is_late(frame.publisher, frame.time_us)) {
    ++old_times;
    return {Reason::kTimeNotIncreasing, "time " + std::to_string(frame.time_us) +
                                            " us is not after " + std::to_string(*last_time_us)};
  }
  const bool begins = begins_stream(frame.publisher);
  const bool any_extractor = !extractor || (begins && !live);
  if (!any_extractor && *extractor != std::pair(frame.extractor, frame.extractor_version))
    return {Reason::kUnknownExtractor,
            "extractor " + std::to_string(static_cast<int>(frame.extractor)) + " version " +
                std::to_string(frame.extractor_version) + ", so far it was " +
                std::to_string(static_cast<int>(extractor->first)) + " version " +
                std::to_string(extractor->second)};
  if (begins) begin_stream(frame);  // which a frame that is refused does not
  if (live && !last_time_us && !lost_since_us) begin_where_it_was(frame.time_us);
  return result;
}

void Mapper::State::count(const FrameResult& result) {
  ++statistics.reasons[result.reason];
  if (result.rejected) {
    ++statistics.rejected;
    return;
  }
  ++statistics.frames;
  if (result.state == TrackingState::kTracking) ++statistics.tracked;
  ++statistics.sources[result.source];
  statistics.moving_matches += result.num_moving;
  statistics.most_moving = std::max<std::int64_t>(statistics.most_moving, result.num_moving);
  statistics.frames_with_moving += result.num_moving > 0;
  if (result.map_updated) count_map();
}

void Mapper::State::count_map() {
  count_measurements();
  statistics.submaps.kept = kept.size();
  statistics.submaps.kept_ids.clear();
  for (const KeptMap& map : kept.all()) statistics.submaps.kept_ids.push_back(map.map_id);
  if (!live) return;
  const Map& map = live->map();
  statistics.keyframes = map.num_keyframes_in_use();
  statistics.landmarks = map.num_landmarks();
  statistics.sigma_factor = map.sigma_factor();
  statistics.removed_keyframes = live->removed_keyframes;
  statistics.removed_landmarks = live->removed_landmarks;
  statistics.edges = map.filter().num_edges();
  statistics.observations = static_cast<std::int64_t>(map.filter().num_measurements());
  for (const InnovationKind kind : {InnovationKind::kSight, InnovationKind::kEdge})
    statistics.nis[kind] = nis.ratio(kind);
  statistics.sigma_suspect = nis.alarm();
}

void Mapper::State::count_measurements() {
  statistics.measurements = desk.refused();
  statistics.measurements += measured_before;
  for (const KeptMap& map : kept.all()) statistics.measurements += map.live.map().scale().counts;
  statistics.measurements_waiting = desk.num_waiting();
  if (!live) return;
  const MapScale& scale = live->map().scale();
  statistics.measurements += scale.counts;
  statistics.measurements_waiting += static_cast<std::int64_t>(scale.waiting.size());
  statistics.scale = scale.state;
  statistics.earth = scale.earth;
}

const FinishedMap* Mapper::State::largest(FinishedMap& scratch) const {
  const LiveMap* most = live ? &*live : nullptr;
  for (const KeptMap& map : kept.all())
    if (!most || map.live.log.size() > most->log.size()) most = &map.live;
  const std::size_t finished_size = finished ? finished->trajectory.size() : 0;
  if (most && most->log.size() >= finished_size) {
    scratch = finish(*most);
    return &scratch;
  }
  return finished ? &*finished : nullptr;
}

Mapper::Mapper(const Camera& camera, const MapperOptions& options) {
  if (const std::string problem = camera.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  state_ = std::make_unique<State>(camera, options);
}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

bool Mapper::is_late(std::int64_t publisher, std::int64_t time_us) const {
  return state_->is_late(publisher, time_us);
}

// [WD10] Algorithm 2 for one image.
FrameResult Mapper::process(const FeatureFrame& frame) {
  State& state = *state_;
  FrameResult result;
  result.time_us = frame.time_us;
  result.publisher = frame.publisher;
  result.seq = frame.seq;

  const FrameCheck check = state.check(frame);
  if (!check.ok()) {
    result.rejected = true;
    result.reason = check.reason;
    result.detail = check.detail;
  } else {
    if (state.job_runs && state.runner->due(frame)) state.adopt_beside(result);
    state.last_time_us = frame.time_us;
    state.old_times = 0;
    state.publisher = frame.publisher;
    state.extractor = {frame.extractor, frame.extractor_version};
    ObservedFrame observed;
    {
      const Step step(state.observer, "observe");
      observed = observe(frame, state.camera, state.map_sign, state.sigma_factor());
    }
    if (!state.live)
      state.start_map(std::move(observed), result);
    else if (state.lost_since_us)
      state.find_again(std::move(observed), result);
    else
      state.track(std::move(observed), result);
    if (result.state != TrackingState::kTracking)
      state.desk.add_frame(PlacedFrame::without_pose(frame.time_us));
    state.calibration.warn(result);
    state.warn_of_bounds(result);
    state.nis.warn(result, state.sigma_factor());
    result.adopted_job = std::exchange(state.adopted_job, 0);
    result.measurements = std::exchange(state.measured, {});
    result.map_updated = std::exchange(state.map_changed, false);
  }
  result.map_id = state.map_id;
  if (state.live) {
    result.map_epoch = state.epoch();
    result.scale = state.live->map().scale().state;
  }
  state.count(result);
  return result;
}

Reason Mapper::add_measurement(const AbsoluteMeasurement& measurement) {
  const Reason reason = state_->desk.add(measurement);
  if (reason == Reason::kNone && measurement.id.seq >= 0)
    state_->measured.push_back(measurement.id);
  state_->count_measurements();
  return reason;
}

void Mapper::set_keyframe_runner(KeyframeRunner* runner, bool with_updates) {
  if (state_->job_runs) throw std::invalid_argument("Mapper: the runner has a job, settle() first");
  state_->runner = runner;
  state_->with_updates = with_updates;
}

bool Mapper::settle() {
  if (!state_->job_runs) return false;
  FrameResult result;
  state_->adopt_beside(result);
  state_->count_map();
  return std::exchange(state_->map_changed, false);
}

MapUpdate Mapper::map_update() {
  if (!state_->live) return {};
  LiveMap& live = *state_->live;
  MapUpdate update =
      live.update ? *std::exchange(live.update, std::nullopt) : live.news.since_last(live.map());
  update.map_id = state_->map_id;
  update.map_epoch = state_->epoch();
  state_->map_changed = false;  // also where it was asked for before a frame said so
  return update;
}

const MapperStatistics& Mapper::statistics() const {
  return state_->statistics;
}

std::vector<TimedPose> Mapper::final_trajectory() const {
  FinishedMap scratch;
  const FinishedMap* map = state_->largest(scratch);
  return map ? map->trajectory : std::vector<TimedPose>();
}

std::vector<TimedPose> Mapper::keyframe_trajectory() const {
  FinishedMap scratch;
  const FinishedMap* map = state_->largest(scratch);
  return map ? map->keyframes : std::vector<TimedPose>();
}

std::vector<MapPoint> Mapper::map_points() const {
  FinishedMap scratch;
  const FinishedMap* map = state_->largest(scratch);
  return map ? map->points : std::vector<MapPoint>();
}

std::vector<KeyframeView> Mapper::keyframes() const {
  return state_->live ? keyframe_views(state_->live->map()) : std::vector<KeyframeView>();
}

std::vector<LandmarkView> Mapper::landmarks() const {
  return state_->live ? landmark_views(state_->live->map()) : std::vector<LandmarkView>();
}

std::optional<RelativeView> Mapper::relative_pose(std::int64_t a, std::int64_t b) const {
  return state_->live ? relative_view(state_->live->map(), a, b) : std::nullopt;
}

std::optional<EarthView> Mapper::in_earth() const {
  return state_->live ? earth_view(state_->live->map()) : std::nullopt;
}

std::vector<std::string> Mapper::audit() const {
  return state_->live ? eifmap::audit(state_->live->map()) : std::vector<std::string>();
}

void Mapper::set_step_observer(StepObserver observer) {
  state_->observer = std::move(observer);
}

}  // namespace eifmap
