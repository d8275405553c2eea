#include "mapper.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "frame_check.h"
#include "map/audit.h"
#include "map/calibration_check.h"
#include "map/frame_covariance.h"
#include "map/keyframe_insertion.h"
#include "map/keyframe_work.h"
#include "map/live_map.h"
#include "map/map_start.h"
#include "map/moving_matches.h"
#include "map/tracking.h"

namespace eifmap {
namespace {

using StepObserver = std::function<void(std::string_view, bool)>;

// Tells the observer when a step begins and ends.
class Step {
 public:
  Step(const StepObserver& observer, std::string_view name) : observer_(observer), name_(name) {
    if (observer_) observer_(name_, true);
  }
  ~Step() {
    if (observer_) observer_(name_, false);
  }
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;

 private:
  const StepObserver& observer_;
  std::string_view name_;
};

}  // namespace

struct Mapper::State {
  State(const Camera& c, const MapperOptions& o)
      : camera(c),
        options(o),
        start(c, o),
        calibration(c, o),
        map_sign(sign_to_start_with(o.map_sign)) {}

  Camera camera;
  MapperOptions options;
  StepObserver observer;
  MapStart start;
  CalibrationCheck calibration;
  std::optional<LiveMap> live;
  std::optional<FinishedMap> finished;  // the largest of those given up
  std::int64_t map_id = 0;
  MapSign map_sign;  // of the map, or of the one to come until its start has chosen
  std::optional<std::int64_t> last_time_us, lost_since_us;
  // Lost for want of a good image, not by what the map said: a good one may go on where it was.
  bool may_go_on = false;
  std::optional<std::pair<Extractor, std::int16_t>> extractor;  // the map's, or the stream's
  std::int64_t publisher = 0;  // of the stream of frames; 0 unknown
  int old_times = 0;           // frames in a row that were refused for their time
  MapperStatistics statistics;
  KeyframeRunner* runner = nullptr;
  bool with_updates = false;
  bool job_runs = false;  // in the runner
  std::int64_t jobs = 0;  // started so far
  // Since the last frame that was not refused; a fault meanwhile must not make them forgotten.
  std::int64_t adopted_job = 0;  // 0 none
  bool map_changed = false;

  FrameCheck check(const FeatureFrame& frame);
  bool begins_stream(const FeatureFrame& frame) const;
  void begin_stream(const FeatureFrame& frame);
  MapperOptions tracking_options() const;
  void lose(std::int64_t time_us, FrameResult& result);
  void start_map(ObservedFrame observed, FrameResult& result);
  void track(ObservedFrame observed, FrameResult& result);
  Tracking try_track(const ObservedFrame& observed);
  void find_again(ObservedFrame observed, FrameResult& result);
  Tracking try_to_go_on(const ObservedFrame& observed);
  Tracking try_relocalize(const ObservedFrame& observed);
  void accept(ObservedFrame observed, const Tracking& tracking, FrameResult& result);
  void add_keyframe(std::shared_ptr<const ObservedFrame> observed, const Tracking& tracking,
                    FrameResult& result);
  KeyframeJob make_job(std::shared_ptr<const ObservedFrame> observed, const Tracking& tracking);
  Reason adopt(KeyframeJob job);
  KeyframeJob finish_job();
  void adopt_beside(FrameResult& result);
  void set_covariance(bool known, const PoseBlock& covariance, FrameResult& result) const;
  void count(const FrameResult& result);
  void count_map();
  const FinishedMap* largest(FinishedMap& scratch) const;
};

// A publisher that was started again, or times that stay behind: one wild time stamp, or a
// recording published twice, must not lock the input.
bool Mapper::State::begins_stream(const FeatureFrame& frame) const {
  constexpr int kPatience = 30;
  return (publisher != 0 && frame.publisher != 0 && frame.publisher != publisher) ||
         old_times >= kPatience;
}

// What was mapped stays; where the camera is now, nobody knows.
void Mapper::State::begin_stream(const FeatureFrame& frame) {
  last_time_us.reset();
  start.reset();
  if (live)
    lost_since_us = frame.time_us, may_go_on = false;
  else
    extractor.reset();
}

FrameCheck Mapper::State::check(const FeatureFrame& frame) {
  FrameCheck result = check_frame(frame, camera);
  if (!result.ok()) return result;
  if (begins_stream(frame)) begin_stream(frame);
  if (last_time_us && frame.time_us <= *last_time_us) {
    ++old_times;
    return {Reason::kTimeNotIncreasing, "time " + std::to_string(frame.time_us) +
                                            " us is not after " + std::to_string(*last_time_us)};
  }
  if (extractor && *extractor != std::pair(frame.extractor, frame.extractor_version))
    return {Reason::kUnknownExtractor,
            "extractor " + std::to_string(static_cast<int>(frame.extractor)) + " version " +
                std::to_string(frame.extractor_version) + ", so far it was " +
                std::to_string(static_cast<int>(extractor->first)) + " version " +
                std::to_string(extractor->second)};
  return result;
}

// [WD10] IV: the first images.
void Mapper::State::start_map(ObservedFrame observed, FrameResult& result) {
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
  if (live) {
    FinishedMap old = finish(*live);
    if (!finished || old.trajectory.size() > finished->trajectory.size()) finished = std::move(old);
  }
  live.emplace(std::move(begun.started->map), camera);
  map_sign = live->map().keyframe(0).observed().map_sign;
  ++map_id;
  ++statistics.starts;
  lost_since_us.reset();
  for (const TimedPose& posed : begun.started->posed)
    live->log.add(posed.time_us, 0, live->map().pose(0).inverse() * posed.world_from_camera);
  live->log.add(time_us, 1, Rigid3());
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
  // Where the camera was lost, the newest, and a few others in turn: a frame's time stays bounded.
  constexpr int kNear = 3, kNewest = 2, kOthers = 3;
  const int n = live->map().num_keyframes();
  std::vector<int> keyframes = live->map().covisible(live->reference, kNear);
  const auto add = [&keyframes](int k) {
    if (std::find(keyframes.begin(), keyframes.end(), k) == keyframes.end()) keyframes.push_back(k);
  };
  for (int k = n - 1; k >= std::max(0, n - kNewest); --k) add(k);
  for (int k = 0; k < kOthers; ++k) add(live->next_to_try++ % n);
  return relocalize(live->map(), observed, keyframes, options);
}

void Mapper::State::find_again(ObservedFrame observed, FrameResult& result) {
  Tracking tracking = try_to_go_on(observed);
  if (!tracking.ok()) tracking = try_relocalize(observed);
  if (tracking.ok()) {
    lost_since_us.reset();
    start.reset();
    return accept(std::move(observed), tracking, result);
  }
  result.state = TrackingState::kLost;
  const double lost_s = 1e-6 * static_cast<double>(observed.frame.time_us - *lost_since_us);
  if (lost_s >= options.lost.new_map_after_s) start_map(std::move(observed), result);
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
      step_in_pixels(map, tracking.sights, live->last.pose, tracking.world_from_camera);
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
  const bool as_keyframe = !job_runs && wants_keyframe(map, tracking, usual, options);
  if (as_keyframe && !runner) return add_keyframe(shared, tracking, result);
  PoseBlock covariance;
  const bool known = frame_covariance(map, *shared, tracking, options.absolute_pose, covariance);
  set_covariance(known, covariance, result);
  live->log.add(result.time_us, tracking.reference, result.reference_from_camera);
  if (!as_keyframe) return;
  runner->start(make_job(shared, tracking));
  job_runs = true;
}

KeyframeJob Mapper::State::make_job(std::shared_ptr<const ObservedFrame> observed,
                                    const Tracking& tracking) {
  auto work = std::make_unique<KeyframeWork>();
  work->id = ++jobs;
  work->map_id = map_id;
  work->options = options;
  work->observed = std::move(observed);
  work->calibration = calibration;
  work->tracking = tracking;
  work->hardly_seen = live->sight_counts.hardly_seen(live->map());
  work->before = live->current;
  work->after = std::move(live->spare);
  if (runner && with_updates) work->news = std::move(live->news);
  return KeyframeJob(std::move(work));
}

// The map with the keyframe becomes the map. With a reason it does not: nothing of it was seen.
Reason Mapper::State::adopt(KeyframeJob job) {
  KeyframeWork& work = job.work();
  adopted_job = work.id;
  if (work.news) live->news = std::move(*work.news);
  calibration = std::move(*work.calibration);
  if (work.insertion.reason != Reason::kNone) {
    live->spare = std::move(work.after);
    return work.insertion.reason;
  }
  // Where the camera is, seen from its reference, has not changed.
  const Rigid3 now_from_before =
      work.after->pose(live->reference) * live->map().pose(live->reference).inverse();
  live->last.pose = now_from_before * live->last.pose;
  live->last.step = now_from_before.rotation * live->last.step;
  if (live->log.newest_is(work.observed->frame.time_us))  // the filter knows better where it was
    live->last.pose = work.after->pose(work.insertion.keyframe);
  live->spare = std::exchange(live->current, std::move(work.after));
  live->update = std::move(work.update);
  live->most_tracked.push_back(static_cast<int>(work.tracking.sights.size()));
  live->log.make_keyframe(work.observed->frame.time_us, work.insertion.keyframe);
  live->reference = work.insertion.keyframe;
  map_changed = true;
  return Reason::kNone;
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
  if (!live || job.work().map_id != map_id) {  // of a map that was given up
    adopted_job = job.id();
    return;
  }
  const std::int64_t time_us = job.work().observed->frame.time_us;
  const Reason reason = adopt(std::move(job));
  if (reason == Reason::kNone || lost_since_us) return;
  lose(time_us, result);
  ++statistics.reasons[reason];
}

void Mapper::State::add_keyframe(std::shared_ptr<const ObservedFrame> observed,
                                 const Tracking& tracking, FrameResult& result) {
  const Step step(observer, "keyframe");
  const std::int64_t time_us = result.time_us;
  KeyframeJob job = make_job(std::move(observed), tracking);
  job.run();
  const int keyframe = job.work().insertion.keyframe;
  result.reason = adopt(std::move(job));
  adopted_job = kAdoptedAtOnce;
  if (result.reason != Reason::kNone) {
    result.detail = "keyframe " + std::to_string(keyframe) + " with " +
                    std::to_string(tracking.sights.size()) + " map features";
    return lose(time_us, result);
  }
  const Map& map = live->map();
  live->log.add(time_us, keyframe, Rigid3());
  live->last.pose = map.pose(keyframe);
  // The pose as the filter now has it is the better one, and what the frame's users get.
  result.map_from_camera = live->last.pose;
  result.reference_keyframe = keyframe;
  result.reference_from_camera = Rigid3();
  PoseBlock covariance;
  set_covariance(map.filter().pose_covariance(keyframe, covariance), covariance, result);
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
  if (!live) return;
  const Map& map = live->map();
  statistics.keyframes = map.num_keyframes();
  statistics.landmarks = map.num_landmarks();
  statistics.edges = map.filter().num_edges();
  statistics.observations = static_cast<std::int64_t>(map.filter().num_measurements());
}

const FinishedMap* Mapper::State::largest(FinishedMap& scratch) const {
  const std::size_t finished_size = finished ? finished->trajectory.size() : 0;
  if (live && live->log.size() >= finished_size) {
    scratch = finish(*live);
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
      observed = observe(frame, state.camera, state.map_sign, state.options.sigma_factor);
    }
    if (!state.live)
      state.start_map(std::move(observed), result);
    else if (state.lost_since_us)
      state.find_again(std::move(observed), result);
    else
      state.track(std::move(observed), result);
    state.calibration.warn(result);
    result.adopted_job = std::exchange(state.adopted_job, 0);
    result.map_updated = std::exchange(state.map_changed, false);
  }
  result.map_id = state.map_id;
  state.count(result);
  return result;
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

std::vector<std::string> Mapper::audit() const {
  return state_->live ? eifmap::audit(state_->live->map()) : std::vector<std::string>();
}

void Mapper::set_step_observer(StepObserver observer) {
  state_->observer = std::move(observer);
}

}  // namespace eifmap
