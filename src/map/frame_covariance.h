// How sure a tracked frame's pose is in the map's gauge.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// What the error of a frame posed by its sights is made of: a part of its own, of its keypoints and
// of the landmarks given the keyframes, and a linear function of the keyframes' errors.
struct FrameError {
  PoseBlock own = PoseBlock::Zero();            // covariance of (w, dc)
  std::vector<PoseSensitivity> from_keyframes;  // of (w, dc)
};
// False when the sights do not determine a pose.
bool frame_error(const Map& map, const ObservedFrame& observed, const Tracking& tracking,
                 const AbsolutePoseOptions& options, FrameError& error);

// Covariance of (w, dc) of a frame posed by its sights: their own noise, the features' uncertainty
// given the keyframes, and the keyframes' joint one, carried through the features to the pose. The
// frame itself is no part of the map and adds nothing to it. False when the filter cannot tell yet,
// or the sights do not determine a pose.
bool frame_covariance(const Map& map, const ObservedFrame& observed, const Tracking& tracking,
                      const AbsolutePoseOptions& options, PoseBlock& covariance);

}  // namespace eifmap
