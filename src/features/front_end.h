// From pixels to what the mapper sees.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "features/surf.h"
#include "frame.h"

namespace eifmap {

// What a frame says about itself, apart from its features.
struct FrameHeader {
  std::int64_t time_us = 0;
  std::int64_t publisher = 0;
  std::int64_t seq = -1;
  std::string camera;
  std::int64_t calibration_id = 0;
};

// `gray`: CV_8UC1. Throws std::invalid_argument on another type, or smaller than the extractor
// takes.
FeatureFrame extract_frame(const SurfExtractor& extractor, const cv::Mat& gray,
                           const FrameHeader& header);

}  // namespace eifmap
