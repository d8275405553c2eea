// The 64-D SURF descriptor (Bay et al. 2008, 4.2).
#pragma once

#include <cstdint>

#include "features/integral_image.h"
#include "frame.h"

namespace eifmap {

// Haar responses of side 2 * scale at 20x20 points of a frame around (u, v) that is turned by
// `angle` (rad, +u towards +v), at exact sub-pixel places, summed in 4x4 overlapping subregions as
// (sum dx, sum |dx|, sum dy, sum |dy|); brought to unit length. The image's border pixels are taken
// to go on outside. Writes kDescriptorSize values round(254 x), |x| <= 0.5; all 0 where the image
// is constant.
void surf_descriptor(const IntegralImage& integral, float u, float v, float scale, float angle,
                     std::int8_t* descriptor);

}  // namespace eifmap
