// The dominant orientation of a blob's surroundings (Bay et al. 2008, 4.1).
#pragma once

#include "features/integral_image.h"

namespace eifmap {

// Haar responses of side 4 * scale in a disc of radius 6 * scale around (u, v), px, weighted by a
// Gaussian; the longest sum within any window of 60 degrees says where the image gets brighter.
// rad in (-pi, pi], +u towards +v; 0 where the image is constant.
float surf_orientation(const IntegralImage& integral, float u, float v, float scale);

}  // namespace eifmap
