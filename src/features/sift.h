// SIFT (D. Lowe, IJCV 2004) as OpenCV finds it, with what the wire wants beside it: the Laplacian's
// sign, the standard deviation of the place, and 64 bytes a descriptor.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "features/features.h"

namespace eifmap {

struct SiftOptions {
  int octave_layers = 3;  // scales searched in each octave
  // Of the difference of Gaussians, for intensities in [0, 1]. Low on purpose, as SURF's
  // min_response: the best max_features above it are kept.
  double contrast_threshold = 0.01;
  double edge_threshold = 10;  // ratio of the principal curvatures

  std::string problem() const;  // "" or which field is wrong and why
};

// `gray`: CV_8UC1. At most `max_features`, one per blob. A pure function of the image, however many
// threads OpenCV has. Response: |difference of Gaussians|.
Features extract_sift(const cv::Mat& gray, const SiftOptions& options, int max_features);

}  // namespace eifmap
