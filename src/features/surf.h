// Upright SURF of our own (H. Bay et al., Speeded-Up Robust Features, CVIU 2008): box-filter
// Hessian determinant over an integral image, sub-pixel maxima, sign of the Laplacian, 64-D
// descriptor.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "frame.h"

namespace eifmap {

struct SurfOptions {
  int max_features = 1000;
  int octaves = 3;
  int sampling_step = 1;  // px between samples in the first octave; 2 is faster and finds less
  // Responses below this (of image intensities in [0, 1]) are noise. Low on purpose: the detector
  // keeps the best max_features above it, so that a dim, low-texture image still gives its own.
  double min_response = 1e-6;

  std::string problem() const;  // "" or which field is wrong and why
};

// What an extractor gives: keypoints and kDescriptorSize int8 per keypoint, in the order and with
// the very values of the wire.
struct Features {
  std::vector<Keypoint> keypoints;
  std::vector<std::int8_t> descriptors;
};

class SurfExtractor {
 public:
  explicit SurfExtractor(const SurfOptions& options = {});  // throws std::invalid_argument

  // `gray`: CV_8UC1, at least 32x32. A pure function of the image: no state is carried from one
  // image to the next. Throws std::invalid_argument on another type or size.
  Features extract(const cv::Mat& gray) const;

 private:
  SurfOptions options_;
};

}  // namespace eifmap
