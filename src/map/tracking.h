// The pose of a new frame in the map: [WD10] Algorithm 1, with the map alone and PnP where it
// cannot give one.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "map/frame_pair.h"
#include "map/map.h"
#include "motion/absolute_pose.h"
#include "motion/relative_pose.h"

namespace eifmap {

// A landmark seen in a frame.
struct LandmarkSight {
  int track = 0, keypoint = 0;
};

struct Tracking {
  Reason reason = Reason::kTooFewInliers;  // kNone: tracked
  std::string detail;                      // the reason's numbers
  PoseSource source = PoseSource::kNone;
  int reference = 0;  // keyframe
  int related = 0;    // keyframe that the relative pose is to: the reference, or an older one where
                      // that is too near
  Rigid3 world_from_camera;
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Zero();  // (w, dc), given the map
  FramePair pair;                           // of `related` and the frame
  std::vector<LandmarkSight> sights;        // inliers, by track ascending
  int num_matches = 0;                      // landmarks matched, inliers or not
  std::vector<int> looked_for;  // tracks of the local map's landmarks, seen or not; ascending

  bool ok() const { return reason == Reason::kNone; }
};

// Where the camera was last. Only a start for where no relative pose can be had, and the length of
// the first guess along one that can: no motion model.
struct LastMotion {
  Rigid3 pose;                                     // of the last tracked frame
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  // world, to it from the one before
};

// Against the reference; where that fails, or so few landmarks agree that it may be by chance,
// against so many of its neighbours and the newest keyframe, and with the most of them.
Tracking track_frame(const Map& map, const ObservedFrame& observed, int reference,
                     const LastMotion& last, const MapperOptions& options, int neighbours = 3);

// The same without any guess: matches the frame with the keyframes given and solves PnP; believed
// from `min_inliers` on. For a lost camera.
Tracking relocalize(const Map& map, const ObservedFrame& observed,
                    const std::vector<int>& keyframes, const MapperOptions& options);

}  // namespace eifmap
