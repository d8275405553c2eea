// START HERE: feature frames in, poses and a map out. process() reads as [WD10] Algorithm 2.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absolute_measurement.h"
#include "frame.h"
#include "geometry/camera.h"
#include "keyframe_job.h"
#include "map_view.h"
#include "options.h"

namespace eifmap {

struct MapperSnapshot;  // map/map_snapshot.h

class Mapper {
 public:
  // Throws std::invalid_argument with camera.problem() or options.problem().
  Mapper(const Camera& camera, const MapperOptions& options);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  // One frame. Bad input comes back as rejected with its reason and changes nothing. A pure
  // function of the frames so far, and of what the runner says is due: no clock, no threads.
  FrameResult process(const FeatureFrame& frame);

  // Whether process() would refuse a frame of these for its time: what it shows need not be looked
  // for.
  bool is_late(std::int64_t publisher, std::int64_t time_us) const;
  // After so many late frames in a row the next one is believed, and begins a stream.
  static constexpr int kPatience = 30;

  // An absolute measurement, of the frames' clock; it may come before or after its frame. It enters
  // the map with the first keyframe that comes after its frame. Says why it is refused at once;
  // what happens to it later is in the statistics. What is made of it is a function of the order of
  // the calls; beside, of when keyframes are made, too (keyframe_job.h).
  Reason add_measurement(const AbsoluteMeasurement& measurement);

  // Keyframes go into the map beside process() from now on, run by `runner`, which must outlive the
  // mapper or be taken out (null) after settle(). Without one, the default, process() does it
  // itself. `with_updates`: map_update() will be asked for. Throws std::invalid_argument while a
  // job runs. What a job throws comes out of process() or settle() as std::runtime_error, and the
  // mapper is not to be used on, since the job had part of its books; its results can still be
  // read.
  void set_keyframe_runner(KeyframeRunner* runner, bool with_updates);
  // Waits for a job that is running and adopts it; true when the map has changed.
  bool settle();

  // What changed since the last call; the first one of each map_epoch is a whole map. To be asked
  // for when a frame or settle() says so.
  MapUpdate map_update();

  const MapperStatistics& statistics() const;

  // What is wrong with the current map's books (map/audit.h), one sentence each: nothing, ever.
  std::vector<std::string> audit() const;

  // Every frame placed in the final map: relative to its keyframe as finally estimated, the start
  // set posed backwards. Of the map that holds the most frames, if there were several: those that
  // have become one are one.
  std::vector<TimedPose> final_trajectory() const;
  std::vector<TimedPose> keyframe_trajectory() const;
  std::vector<MapPoint> map_points() const;

  // The keyframes of the map in use with their covariances of now, by age; none before the start.
  std::vector<KeyframeView> keyframes() const;
  // Its landmarks with theirs.
  std::vector<LandmarkView> landmarks() const;
  // Keyframe b seen from keyframe a, of the map in use, as of now; nothing where one of them is not
  // in it (never was, or has been removed), or its covariance is not known.
  std::optional<RelativeView> relative_pose(std::int64_t a, std::int64_t b) const;
  // Nothing before absolute positions have told where the map is.
  std::optional<EarthView> in_earth() const;

  // Tracks in the maps that there are, and makes nothing of what it sees: no keyframe, no new map,
  // and the maps stay as they are to the bit. MapperOptions says what it begins with.
  void localize_only(bool only);
  bool localizes_only() const;

  // For a map that outlives its process (storage/): what there is now; and a mapper that has had no
  // frame yet goes on from there, lost until an image shows where the camera is. What was tracked
  // since the last keyframe, and what was only counted, is not in it. restore() throws
  // std::invalid_argument after the first frame.
  MapperSnapshot snapshot() const;
  void restore(const MapperSnapshot& snapshot);

  // Called with a step's name at its start and end, for timing from outside: the mapper itself
  // reads no clock. (name, true) at start, (name, false) at end.
  void set_step_observer(std::function<void(std::string_view, bool)> observer);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace eifmap
