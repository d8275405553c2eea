// Where a texture repeats, an image may agree with the map from more than one place.
#pragma once

#include <vector>

#include "geometry/rigid3.h"
#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// How far apart two poses see the landmarks of the sights: the median, normalized image
// coordinates. Infinite for a landmark that is behind one of them; 0 of no sights.
double median_shift(const Map& map, const std::vector<LandmarkSight>& sights, const Rigid3& a,
                    const Rigid3& b);

enum class PlaceChoice { kFar, kNear, kNeither };

// Of two places with so many map features that agree: the one far from where the camera was last,
// the other near it. The far one needs clearly more to be believed, the near one only as many.
PlaceChoice choose_place(int far_inliers, int near_inliers);

}  // namespace eifmap
