// SURF of our own (H. Bay et al., Speeded-Up Robust Features, CVIU 2008): box-filter Hessian
// determinant over an integral image, sub-pixel maxima, sign of the Laplacian, 64-D descriptor.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "features/features.h"
#include "features/image_pyramid.h"
#include "features/integral_image.h"

namespace eifmap {

struct SurfOptions {
  int octaves = 3;        // of the scale space, each of twice the blobs' size
  int sampling_step = 1;  // px between samples in the first octave; 2 is faster and finds less
  // Responses below this (of image intensities in [0, 1]) are noise. Low on purpose: the detector
  // keeps the best max_features above it, so that a dim, low-texture image still gives its own.
  double min_response = 1e-6;

  std::string problem() const;  // "" or which field is wrong and why
};

// An image prepared for finding and describing blobs, and the memory for the next one.
class SurfImage {
 public:
  explicit SurfImage(const SurfOptions& options) : options_(options) {}

  // From then on this is the image. `gray`: CV_8UC1; std::invalid_argument on another type.
  void assign(const cv::Mat& gray);

  // The best `max_features` blobs, in the wire's order, upright.
  std::vector<Keypoint> find_keypoints(int max_features) const;

  // The dominant orientation of each keypoint becomes its angle.
  void orient(std::vector<Keypoint>& keypoints) const;

  // kDescriptorSize bytes per keypoint, each in the frame turned by its keypoint's angle.
  std::vector<std::int8_t> describe(std::span<const Keypoint> keypoints) const;

 private:
  SurfOptions options_;
  IntegralImage integral_;
  ImagePyramid pyramid_;
};

}  // namespace eifmap
