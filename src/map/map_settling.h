// What a map that was bent or put together does not say by itself: whether the filter agrees.
#pragma once

#include <vector>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// To the mean from a start that is far from it for an update, which would throw out what does not
// fit yet, and keep what happens to agree with where the map was. False where it does not get
// nearer.
bool settle(Map& map);

// Of the landmarks that were joined with what the keyframe sees, those that it still sees.
int sights_left(const Map& map, int keyframe, const std::vector<LandmarkSight>& sights);

}  // namespace eifmap
