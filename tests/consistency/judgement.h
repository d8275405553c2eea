// One run of the mapper, judged against the truth: how large its errors are next to what its
// covariances say.
#pragma once

#include <optional>
#include <vector>

#include "consistency/frame_source.h"
#include "map_view.h"
#include "options.h"
#include "sequence/consistency.h"

namespace eifmap::test {

// An estimated pose next to the true one, both in the map's gauge.
struct JudgedPose {
  std::int64_t time_us = 0;
  std::int64_t map_id = 0;
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();  // centre, map
  PoseVector error = PoseVector::Zero();            // (centre, rotation)
  PoseMatrix covariance = PoseMatrix::Zero();
  double nees = 0;           // of 6 degrees of freedom
  double nees_centre = 0;    // of 3, the rotation's share left open
  double nees_rotation = 0;  // of 3
};

struct JudgedRun {
  int frames = 0, tracked = 0;
  MapperStatistics statistics;
  int first_alarm = 0;  // keyframes in the map when its sigmas were first suspect; 0 never
  // As published, frame by frame, and the keyframes as they are at the end. Without those that the
  // gauge holds: keyframe 0 is the origin by definition, and keyframe 1 is not free to move along
  // the first baseline.
  std::vector<JudgedPose> published, keyframes;
  // Normalized errors squared of the map at the end: of its landmarks; of its keyframes to those
  // some before them; of both where earth is.
  std::vector<double> landmarks, relative, earth_keyframes, earth_landmarks;
  // Of the scale's logarithm, since it is fixed: at the newest keyframes, keyframe by keyframe as
  // published; of all the map at the end.
  struct ScaleError {
    std::int64_t time_us = 0;
    double error = 0, sigma = 0;
    double in_sigmas() const { return error / sigma; }
  };
  std::vector<ScaleError> scale_newest;
  std::optional<ScaleError> scale_of_all;
  std::vector<FrameResult> results;  // of all frames
  std::vector<TimedPose> final_trajectory;
  double scale = 0;         // map units per unit of the truth, of the last map
  double mapper_cpu_s = 0;  // of this thread, in the mapper
};

// `measurements`: given each before the first frame that is not before it, of a world that lies in
// theirs as `earth_from_world` says.
JudgedRun judge_run(const FrameSource& source, const MapperOptions& options, int every = 1,
                    const std::vector<AbsoluteMeasurement>& measurements = {},
                    const Rigid3& earth_from_world = {});

// Mean NEES of poses; nothing when there are none.
std::optional<double> mean_nees(const std::vector<JudgedPose>& poses);

// Share of the poses whose truth is within the 6-dimensional ellipsoid that a Gaussian fills to
// 99.73 %, as 3 sigma does in one dimension: NEES <= 20.062.
double share_within_three_sigma(const std::vector<JudgedPose>& poses);

}  // namespace eifmap::test
