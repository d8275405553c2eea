// Whether the newest keyframe is where it seems to have been before.
#pragma once

#include <string>
#include <vector>

#include "geometry/similarity.h"
#include "map/map.h"
#include "map/tracking.h"
#include "options.h"

namespace eifmap {

// The newest keyframe in the map of an old place.
struct LoopFit {
  Reason reason = Reason::kNone;  // or why it is not believed
  std::string detail;             // with its numbers
  int old = 0, newest = 0;        // keyframes
  // As the old place's landmarks say; its scale is how much what is near the newest must grow.
  Similarity world_from_newest;
  PoseBlock covariance = PoseBlock::Zero();  // of its (w, dc), given the old place
  double sigma_log_scale = 0;
  std::vector<LandmarkSight> sights;  // the old place's landmarks in the newest keyframe

  bool ok() const { return reason == Reason::kNone; }
};

// Pose and scale: P3P on the landmarks of `old` that the newest keyframe matches, confirmed by all
// around them; the scale from the depths of the features that are landmarks on both sides. That is
// the similarity that brings these on each other, but by where they are seen, which is known well,
// with the depths for the one number that needs them. Not believed on few landmarks, on such as are
// all in one part of the image, or where the depths do not agree on one scale.
LoopFit fit_loop(const Map& map, int old, int newest, const MapperOptions& options);

// The same of two maps: `newest` is one of `here`, the old place and the fit's landmarks, pose and
// scale are of `there`.
LoopFit fit_place(const Map& there, int old, const Map& here, int newest,
                  const MapperOptions& options);

// What two poses of one keyframe may differ by: chi-square of 6 degrees of freedom, 1 in 10,000; of
// the scale's logarithm, as many sigmas. And what is in no covariance: rad; of the scale's
// logarithm.
inline constexpr double kPoseGate = 27.86, kScaleGate = 3.9;
inline constexpr double kRotationFloor = 0.01, kScaleFloor = 0.03;

// Whether the map may be as far off as the loop says, by the filter's own covariance of the two
// keyframes to each other and of their scales; generously, for what the calibration adds is in no
// keypoint's sigma.
void check_possible(const Map& map, const LoopOptions& options, LoopFit& fit);

// Whether another place explains the newest keyframe about as well.
void check_only_place(const Map& map, const MapperOptions& options, LoopFit& fit);

// The same of a keyframe that need not be one of the map's, against the keyframes that are
// `elsewhere` (by keyframe 1) but for what shares landmarks with the old place.
void check_only_place(const Map& map, const ObservedFrame& observed, std::vector<char> elsewhere,
                      const MapperOptions& options, LoopFit& fit);

}  // namespace eifmap
