// What leaves the mapper: a pose per frame, map updates per keyframe, trajectories, counts.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "absolute_measurement.h"
#include "geometry/rigid3.h"
#include "reason.h"

namespace eifmap {

// The wire's values.
enum class TrackingState : std::int8_t { kWaiting = 0, kStarting = 1, kTracking = 2, kLost = 3 };
enum class PoseSource : std::int8_t {
  kNone = 0,
  // Relative pose, its length from the scale fit against the map ([WD10] III) or, where the map
  // does not confirm that, from another way along the line that it does confirm.
  kScaleFit = 1,
  kMapOnly = 2,  // from the map alone: too little baseline for a relative pose
  kPnp = 3,      // fallback
  kRelocalized = 4,
  kStartSet = 5,  // one of the first images
};
enum class CovarianceStatus : std::int8_t { kNone = 0, kValid = 1, kOptimistic = 2 };

inline constexpr std::int64_t kAdoptedAtOnce = -1;

// One per processed frame, lost ones too.
struct FrameResult {
  std::int64_t time_us = 0, publisher = 0, seq = -1;
  // The map that the pose rests on. map_id is its name; map_epoch grows by every correction of all
  // of it, and whenever another map is in use, be it one of before: maps are ordered by it.
  std::int64_t map_id = 0, map_epoch = 0, map_seq = 0;
  TrackingState state = TrackingState::kWaiting;
  PoseSource source = PoseSource::kNone;
  Reason reason = Reason::kNone;
  std::string detail;      // the reason's numbers, in words
  Rigid3 map_from_camera;  // valid while state is kTracking
  ScaleState scale;        // of that map
  CovarianceStatus covariance_status = CovarianceStatus::kNone;
  // Of (centre in map, rotation vector in the camera's frame): the wire's order.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::int64_t reference_keyframe = -1;  // map_from_camera = map_from_reference * the next
  Rigid3 reference_from_camera;
  int num_matches = 0, num_inliers = 0;
  // Of the matches with a keyframe, those that are seen well but move on their own
  // (map/moving_matches.h says exactly which): about 0 where nothing moves. They are not used.
  int num_moving = 0;
  bool rejected = false;     // bad input: the map is untouched
  bool map_updated = false;  // Mapper::map_update() has news
  // The keyframe's job that was adopted since the frame before, 0 none, kAdoptedAtOnce where this
  // frame became a keyframe itself: what a live run decides by timing (keyframe_job.h).
  std::int64_t adopted_job = 0;
  // The absolute measurements that the mapper took since the frame before, of those that have a
  // name: decided by timing, too.
  std::vector<MeasurementId> measurements = {};
  // The first frame since the map was given up by command: that is up to who commands, and so
  // decided by timing, too. The mapper, which is another one, does not know it.
  bool after_reset = false;
};

// Users are given a pose's covariance as of (centre, rotation); inside it is of (rotation, centre).
inline Eigen::Matrix<double, 6, 6> centre_first(const Eigen::Matrix<double, 6, 6>& rotation_first) {
  Eigen::Matrix<double, 6, 6> out;
  out << rotation_first.bottomRightCorner<3, 3>(), rotation_first.bottomLeftCorner<3, 3>(),
      rotation_first.topRightCorner<3, 3>(), rotation_first.topLeftCorner<3, 3>();
  return out;
}

// A covariance that nobody can tell is this: never zero or identity.
template <int N>
Eigen::Matrix<double, N, N> unknown_covariance() {
  return Eigen::Matrix<double, N, N>::Constant(std::numeric_limits<double>::quiet_NaN());
}

struct KeyframeView {
  std::int64_t id = 0, time_us = 0;
  Rigid3 map_from_camera;
  // As FrameResult's; zero for the first keyframe, which is the map's frame. unknown_covariance()
  // when unknown.
  Eigen::Matrix<double, 6, 6> covariance = unknown_covariance<6>();
};

struct LandmarkView {
  std::int64_t id = 0, anchor = 0;     // anchor: a keyframe's id
  Eigen::Vector3d position_in_anchor;  // so that a correction moves keyframes only
  int laplacian_sign = 0;
  int num_observations = 0;
  // Of the position in the map; unknown_covariance() when unknown.
  Eigen::Matrix3d covariance = unknown_covariance<3>();
};

// Where a keyframe is, seen from another one.
struct RelativeView {
  Rigid3 a_from_b;
  // Of (b's centre in a's camera frame, rotation vector in b's camera frame); zero of a keyframe to
  // itself. Where the map's frame is does not matter to it; its unit does: until the scale is fixed
  // that is the first baseline's length.
  Eigen::Matrix<double, 6, 6> covariance = unknown_covariance<6>();
};

// A map in the frame that absolute positions are in, "earth", whose z axis is up as soon as gravity
// is measured. What earth_from_map may be off by is
// in the covariances, together with what the map says and not on top of it; all are unknown as long
// as the positions do not tell how earth is turned, as on a straight way.
struct EarthView {
  struct Keyframe {
    std::int64_t id = 0, time_us = 0;
    Rigid3 earth_from_camera;
    // Of (centre in earth, rotation vector in the camera's frame).
    Eigen::Matrix<double, 6, 6> covariance = unknown_covariance<6>();
  };
  struct Landmark {
    std::int64_t id = 0;
    Eigen::Vector3d position;  // earth
    Eigen::Matrix3d covariance = unknown_covariance<3>();
  };
  Rigid3 earth_from_map;
  bool placed = false;  // or level alone: its z axis up; where it is, and its turn about up, by
                        // definition, and lengths in the map's unit
  std::vector<Keyframe> keyframes;
  std::vector<Landmark> landmarks;
};

struct ObservationView {
  std::int64_t keyframe = 0, landmark = 0;
  float u = 0, v = 0;  // px, raw
};

// What changed since the last update.
struct MapUpdate {
  std::int64_t map_id = 0, map_epoch = 0;
  // After and before this update; base -1: a whole map. Each map counts its own; what is published
  // is numbered through (server/camera_mapper.h).
  std::int64_t seq = 0, base_seq = -1;
  std::vector<KeyframeView> keyframes;  // new or moved
  std::vector<LandmarkView> landmarks;  // new or changed
  std::vector<std::int64_t> removed_landmarks;
  std::vector<ObservationView> observations;          // new
  std::vector<ObservationView> removed_observations;  // of landmarks that are still there
};

struct TimedPose {
  std::int64_t time_us = 0;
  Rigid3 world_from_camera;
};

struct MapPoint {
  Eigen::Vector3d position;  // world
  int laplacian_sign = 0;
  int num_observations = 0;
};

// What the filter fuses.
enum class InnovationKind : std::int8_t { kSight = 0, kEdge = 1 };
inline constexpr int kInnovationKinds = 2;

// Normalized innovations squared over their expectation, of the last keyframes: 1 where sigmas are
// right, 4 where the noise is twice what they say.
struct NisRatio {
  double ratio = 0, sigma = 0;  // 0: cannot be told yet
  int count = 0, beyond = 0;    // measurements it is of, and those left out as outliers
};

// Places seen again, of all maps.
struct LoopCounts {
  std::int64_t closed = 0;  // and the map was bent
  std::int64_t joined = 0;  // both passes agreed already
  std::map<Reason, std::int64_t> refused;
  std::string last;  // what became of the last one, in words
};

// Maps that the camera left, and what became of them.
struct SubmapCounts {
  std::int64_t kept = 0;                    // now, beside the one in use
  std::vector<std::int64_t> kept_ids = {};  // theirs
  std::int64_t returned = 0;                // times that the camera was found in one
  std::int64_t merged = 0;                  // times that one became one with the map in use
  std::map<Reason, std::int64_t> refused;   // merges
  std::string last;                         // what became of the last one, in words
};

struct MapperStatistics {
  std::int64_t frames = 0;   // processed, rejected ones left out
  std::int64_t tracked = 0;  // with a pose at the time
  std::int64_t keyframes = 0, landmarks = 0, observations = 0, edges = 0;  // in the current map
  double sigma_factor = 0;  // of the current map: what it multiplies keypoints' sigmas by
  // From it, to stay within its bounds.
  std::int64_t removed_keyframes = 0, removed_landmarks = 0;
  std::int64_t starts = 0, losses = 0, rejected = 0;
  // FrameResult::num_moving: of all frames, of the one with the most, and the frames with any.
  std::int64_t moving_matches = 0, most_moving = 0, frames_with_moving = 0;
  std::map<InnovationKind, NisRatio> nis;
  bool sigma_suspect = false;  // the alarm of map/nis_monitor.h, now
  std::map<PoseSource, std::int64_t> sources;
  std::map<Reason, std::int64_t> reasons;
  LoopCounts loops;
  SubmapCounts submaps;
  ScaleState scale;  // of the current map
  EarthState earth;  // of it
  // Absolute measurements of all maps: used, refused, and those that still wait.
  MeasurementCounts measurements;
  std::int64_t measurements_waiting = 0;
};

}  // namespace eifmap
