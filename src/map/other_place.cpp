#include "map/other_place.h"

namespace eifmap {

PlaceChoice choose_place(int far_inliers, int near_inliers) {
  // What is there once and not again, like the ends of a wall, is a part of what is in view only.
  constexpr double kSimilar = 0.7;
  if (near_inliers >= far_inliers) return PlaceChoice::kNear;
  return near_inliers < kSimilar * far_inliers ? PlaceChoice::kFar : PlaceChoice::kNeither;
}

}  // namespace eifmap
