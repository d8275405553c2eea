// Blobs: maxima of the box-filter Hessian's determinant over place and scale.
#pragma once

#include <vector>

#include "features/integral_image.h"

namespace eifmap {

// A maximum on the sampling grid, still coarse.
struct BlobCandidate {
  int x = 0, y = 0;   // px
  int lobe = 0;       // of the filter that responds most
  int lobe_step = 0;  // to the filters it was compared with
  float response = 0;
  int sign = 0;  // of Lxx + Lyy
};

// A maximum refined to parts of a pixel.
struct Blob {
  float u = 0, v = 0;  // px; the centre of the top-left pixel is (0, 0)
  float scale = 0;     // px, sigma
  float response = 0;  // determinant
  int sign = 0;        // of Lxx + Lyy
};

// Maxima above `min_response` within 3x3x3 neighbours, in all octaves. Row by row within an
// octave's level, finest first. `step`: px between samples in the first octave, doubled in each
// further one.
std::vector<BlobCandidate> find_blobs(const IntegralImage& integral, int octaves, int step,
                                      float min_response);

// False if there is no maximum of its own near the candidate.
bool refine_blob(const IntegralImage& integral, const BlobCandidate& candidate, Blob& blob);

}  // namespace eifmap
