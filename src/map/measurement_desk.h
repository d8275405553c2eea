// Where absolute measurements wait for the images of their time.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "absolute_measurement.h"
#include "map/map.h"
#include "map/placed_measurement.h"
#include "options.h"

namespace eifmap {

// A processed frame.
struct PlacedFrame {
  std::int64_t time_us = 0;
  int keyframe = -1;  // that it is placed relative to; -1: it has no pose
  Rigid3 keyframe_from_camera;
  // Given the keyframe: of w in the camera's frame, and of the centre in the keyframe's, map units.
  // Of each frame of a long run, so in half the bytes.
  Eigen::Matrix3f turn_covariance = Eigen::Matrix3f::Zero();
  Eigen::Matrix3f centre_covariance = Eigen::Matrix3f::Zero();

  void grow(double factor);  // what is in the map's unit
  static PlacedFrame without_pose(std::int64_t time_us) { return as_keyframe(time_us, -1); }
  static PlacedFrame as_keyframe(std::int64_t time_us, int keyframe) {
    PlacedFrame frame;
    frame.time_us = time_us;
    frame.keyframe = keyframe;
    return frame;
  }
};

class MeasurementDesk {
 public:
  explicit MeasurementDesk(const MeasurementOptions& options) : options_(options) {}

  // Refused when its numbers are bad or too many wait.
  Reason add(const AbsoluteMeasurement& measurement);
  // Later than all before.
  void add_frame(const PlacedFrame& frame);
  // The frame of that time, which has been added, is a keyframe now.
  void make_keyframe(std::int64_t time_us, int keyframe);
  void make_metric(double metres_per_unit);
  // By keyframe, how much what is near it has grown: Map::bend().
  void grow(const std::vector<double>& growth);
  void forget_frames() { frames_.clear(); }
  // When another map becomes the one in use: its frames for those so far.
  std::deque<PlacedFrame> change_frames(std::deque<PlacedFrame> frames) {
    return std::exchange(frames_, std::move(frames));
  }
  // Another map is in the one in use now: its frames. Or, where the one in use is in the other:
  // `appended` is of those so far.
  void include(const std::deque<PlacedFrame>& frames, const Appended& appended, bool is_in_other);

  // One that waits, or was taken.
  struct Entry {
    AbsoluteMeasurement measurement;
    int failures = 0;  // of the keyframe that it was to enter the map with
  };
  // Those whose time has passed, placed in the map or refused, in the order of adding.
  struct Taken {
    std::vector<PlacedMeasurement> placed;
    std::vector<Entry> entries;  // what was placed
  };
  Taken take(const Map& map, std::int64_t map_id);
  // Taken ones of a keyframe that did not come into the map, for `reason`: with the next one. A
  // full map and one that was given up (kNone) are no fault of theirs; with two keyframes that
  // failed they are refused, since they may be the reason.
  void put_back(std::vector<Entry> entries, Reason reason);

  const MeasurementCounts& refused() const { return refused_; }
  int num_waiting() const { return static_cast<int>(waiting_.size()); }

 private:
  // The frames around a time: the nearest, and where that has a share in the camera's place the one
  // on the time's other side.
  struct Between {
    const PlacedFrame *nearest = nullptr, *other = nullptr;
    double share = 0;  // of the other's
  };
  Reason find(const Map& map, std::int64_t time_us, Between& between) const;
  Reason place(const Map& map, std::int64_t time_us, const Eigen::Vector3d& lever,
               PlacedPoint& point) const;
  Reason place_gravity(const Map& map, const AbsoluteMeasurement& measurement,
                       PlacedMeasurement& placed) const;
  Reason place_way(const Map& map, const AbsoluteMeasurement& measurement,
                   PlacedMeasurement& placed) const;
  Reason place(const Map& map, std::int64_t map_id, const AbsoluteMeasurement& measurement,
               PlacedMeasurement& placed) const;

  MeasurementOptions options_;
  std::vector<Entry> waiting_;
  std::deque<PlacedFrame> frames_;  // of the map in use, by time
  MeasurementCounts refused_;
};

}  // namespace eifmap
