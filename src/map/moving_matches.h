// Things that move on their own: counted, so that one can tell what the map has to survive.
#pragma once

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// Of a tracked frame's matches with the keyframe that it is related to, those that are seen well
// but move on their own:
// - the descriptors are each other's best and clearly better than the second best (the matcher's
//   rules);
// - no place in the scene explains the match, given the two poses: a landmark's own place, else any
//   from a quarter of the depth of what is mapped nearest to infinity. It is off by more than 5
//   sigmas, 3 pixels, and 10 times the median of the frame's matches;
// - six more within 0.15 rad are off in about the same way: a wrong match goes its own.
// Of both signs, landmarks or not. What moves exactly along its epipolar line, as a car ahead may,
// looks like something at another depth and is not counted. 0 without a pose or without such
// matches (relocalized).
int count_moving_matches(const Map& map, const ObservedFrame& observed, const Tracking& tracking);

}  // namespace eifmap
