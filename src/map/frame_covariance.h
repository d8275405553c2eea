// How sure a tracked frame's pose is in the map's gauge.
#pragma once

#include <Eigen/Core>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// Covariance of (w, dc) of a frame posed by its sights: their own noise, the features' uncertainty
// given the keyframes, and the keyframes' joint one, carried through the features to the pose. The
// frame itself is no part of the map and adds nothing to it. False when the filter cannot tell yet,
// or the sights do not determine a pose.
bool frame_covariance(const Map& map, const ObservedFrame& observed, const Tracking& tracking,
                      const AbsolutePoseOptions& options, PoseBlock& covariance);

}  // namespace eifmap
