// How far apart two poses see the same landmarks.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/rigid3.h"
#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// How the landmarks of the sights move in the image from one pose to the other, normalized image
// coordinates: the median of each axis, of those in front of both.
Eigen::Vector2d median_step(const Map& map, const std::vector<LandmarkSight>& sights,
                            const Rigid3& from, const Rigid3& to);

// How far: the median. Infinite for a landmark that is behind one of them; 0 of no sights.
double median_shift(const Map& map, const std::vector<LandmarkSight>& sights, const Rigid3& a,
                    const Rigid3& b);

}  // namespace eifmap
