#include "map/other_place.h"

#include <limits>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {

double median_shift(const Map& map, const std::vector<LandmarkSight>& sights, const Rigid3& a,
                    const Rigid3& b) {
  const Projector from_a(a), from_b(b);
  std::vector<double> shifts;
  shifts.reserve(sights.size());
  for (const LandmarkSight& sight : sights) {
    const Eigen::Vector3d& position = map.position(sight.track);
    Eigen::Vector2d in_a, in_b;
    const bool seen = from_a(position, in_a) && from_b(position, in_b);
    shifts.push_back(seen ? (in_a - in_b).norm() : std::numeric_limits<double>::infinity());
  }
  return take_median(shifts);
}

PlaceChoice choose_place(int far_inliers, int near_inliers) {
  // What is there once and not again, like the ends of a wall, is a part of what is in view only.
  constexpr double kSimilar = 0.7;
  if (near_inliers >= far_inliers) return PlaceChoice::kNear;
  return near_inliers < kSimilar * far_inliers ? PlaceChoice::kFar : PlaceChoice::kNeither;
}

}  // namespace eifmap
