// Blobs: maxima of the box-filter Hessian's determinant over place and scale (Bay et al.
// 2008, 3.3), then of the Gaussian one: boxes are fast and find them, Gaussians say where they are.
#pragma once

#include <optional>
#include <vector>

#include "features/image_pyramid.h"
#include "features/integral_image.h"

namespace eifmap {

// A maximum among the box filters' samples.
struct BlobCandidate {
  int x = 0, y = 0;    // px
  int lobe = 0;        // of the filter that responds most
  int lobe_step = 0;   // to the filters it was compared with
  float response = 0;  // determinant
  int sign = 0;        // of Lxx + Lyy
};

// A maximum of sigma^4 (Lxx Lyy - Lxy^2) over place and sigma.
struct Blob {
  double u = 0, v = 0;  // px; the centre of the top-left pixel is (0, 0)
  double sigma_px = 0;  // px, standard deviation of (u, v), each axis
  double scale = 0;     // px, sigma
  double response = 0;  // the determinant there, of intensities in [0, 1]
  int sign = 0;         // of Lxx + Lyy
};

// Maxima above `min_response` among 3x3x3 neighbours. `step`: px between samples in the first
// octave, doubled in each further one.
std::vector<BlobCandidate> find_blobs(const IntegralImage& integral, int octaves, int step,
                                      float min_response);

// Nothing if no maximum over place and scale is near the candidate: then its place is not sure.
std::optional<Blob> refine_blob(const IntegralImage& integral, const ImagePyramid& pyramid,
                                const BlobCandidate& candidate);

}  // namespace eifmap
