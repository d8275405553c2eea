// Where a texture repeats, an image may agree with the map from more than one place.
#pragma once

namespace eifmap {

enum class PlaceChoice { kFar, kNear, kNeither };

// Of two places with so many map features that agree: the one far from where the camera was last,
// the other near it. The far one needs clearly more to be believed, the near one only as many.
PlaceChoice choose_place(int far_inliers, int near_inliers);

}  // namespace eifmap
