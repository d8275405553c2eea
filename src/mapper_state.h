// What a mapper holds between two frames, and the steps of process(): for the mapper's own files.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "frame_check.h"
#include "map/calibration_check.h"
#include "map/kept_maps.h"
#include "map/live_map.h"
#include "map/loop_closing.h"
#include "map/map_start.h"
#include "map/measurement_desk.h"
#include "map/nis_monitor.h"
#include "map/tracking.h"
#include "mapper.h"

namespace eifmap {

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

struct Mapper::State {
  State(const Camera& c, const MapperOptions& o)
      : camera(c),
        options(o),
        start(c, o),
        calibration(c, o),
        desk(o.measurement),
        kept(o.lost.max_kept_maps),
        localize_only(o.localize_only),
        map_sign(sign_to_start_with(o.map_sign)) {}

  Camera camera;
  MapperOptions options;
  StepObserver observer;
  MapStart start;
  CalibrationCheck calibration;
  NisMonitor nis;
  MeasurementDesk desk;
  MeasurementCounts measured_before;  // in maps that were given up
  std::optional<LiveMap> live;
  KeptMaps kept;
  bool localize_only;
  std::optional<FinishedMap> finished;       // the largest of those given up
  std::int64_t map_id = 0, last_map_id = 0;  // of the map in use, of the one started last
  std::int64_t first_epoch = 0;              // of the first map
  std::int64_t epoch_before = 0;        // what the published one is more than the map in use says
  std::int64_t stay = 0;                // counts how often the map in use has become another one
  std::optional<std::int64_t> seen_in;  // kept map that the last image of a lost camera agrees with
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
  std::vector<MeasurementId> measured;

  // mapper.cpp: what comes in, and what is said of it
  FrameCheck check(const FeatureFrame& frame);
  void begin_where_it_was(std::int64_t time_us);
  bool begins_stream(std::int64_t of_publisher) const;
  bool is_late(std::int64_t of_publisher, std::int64_t time_us) const;
  void begin_stream(const FeatureFrame& frame);
  void count(const FrameResult& result);
  void count_map();
  double sigma_factor() const { return live ? live->map().sigma_factor() : options.sigma_factor; }
  void count_measurements();
  const FinishedMap* largest(FinishedMap& scratch) const;

  // mapper_tracking.cpp: a frame's pose, lost and found
  void start_map(ObservedFrame observed, FrameResult& result);
  void track(ObservedFrame observed, FrameResult& result);
  void find_again(ObservedFrame observed, FrameResult& result);
  void lose(std::int64_t time_us, FrameResult& result);
  void accept(ObservedFrame observed, const Tracking& tracking, FrameResult& result);
  void add_frame(const ObservedFrame& observed, const Tracking& tracking, FrameResult& result);
  Tracking try_track(const ObservedFrame& observed);
  Tracking try_to_go_on(const ObservedFrame& observed);
  Tracking try_relocalize(const ObservedFrame& observed);
  MapperOptions tracking_options() const;
  void set_covariance(bool known, const PoseBlock& covariance, FrameResult& result) const;

  // mapper_submaps.cpp: maps that are left, come back to, and become one
  std::int64_t epoch() const { return live ? epoch_before + live->map().epoch() : 0; }
  void begin_epoch(std::int64_t epoch);
  void leave_map();
  void check_seen(const LiveMap& there, const ObservedFrame& observed, Tracking& tracking) const;
  Tracking find_in(LiveMap& there, const FeatureFrame& frame, ObservedFrame& observed) const;
  bool is_only_there(const Tracking& found, std::int64_t found_in, const FeatureFrame& frame);
  bool find_in_kept(const ObservedFrame& observed, FrameResult& result);
  void return_to(std::int64_t kept_map, ObservedFrame observed, const Tracking& tracking,
                 FrameResult& result);
  void adopt_merge(KeyframeWork& work);

  // mapper_keyframes.cpp: a frame's way into the map
  void add_keyframe(std::shared_ptr<const ObservedFrame> observed, const Tracking& tracking,
                    FrameResult& result);
  bool takes_keyframes();
  void warn_of_bounds(FrameResult& result) const;
  KeyframeJob make_job(std::shared_ptr<const ObservedFrame> observed, const Tracking& tracking);
  Reason adopt(KeyframeJob job);
  void count_loop(const LoopOutcome& loop);
  KeyframeJob finish_job();
  void adopt_beside(FrameResult& result);
};

}  // namespace eifmap
