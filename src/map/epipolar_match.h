// Features of two keyframes matched along the epipolar lines that their poses give: far fewer
// rivals than in the whole image, so that more true matches pass the ratio test.
#pragma once

#include <vector>

#include "features/matcher.h"
#include "geometry/rigid3.h"
#include "map/observed_frame.h"

namespace eifmap {

struct EpipolarMatchOptions {
  double max_error = 3;       // distance from the epipolar line, whitened
  double max_ratio = 0.8;     // of descriptor distances, to the second best near the line
  double max_distance = 0.6;  // of descriptors as unit vectors
};

// `i`, `j`: keypoints that take part, by index in their frames. Mutual best; a: in i, b: in j;
// sorted by a. The two centres must differ.
std::vector<Match> match_along_epipolar_lines(const ObservedFrame& frame_i,
                                              const std::vector<int>& i,
                                              const ObservedFrame& frame_j,
                                              const std::vector<int>& j, const Rigid3& world_from_i,
                                              const Rigid3& world_from_j,
                                              const EpipolarMatchOptions& options);

}  // namespace eifmap
