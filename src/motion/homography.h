// Does a plane explain the matches?
#pragma once

#include <span>

#include "motion/relative_pose.h"

namespace eifmap {

// Share of the chosen matches (`chosen`: one flag per match) that one homography explains to within
// their noise; 0 of nothing.
double homography_inlier_ratio(std::span<const Correspondence> matches,
                               std::span<const std::uint8_t> chosen);

}  // namespace eifmap
