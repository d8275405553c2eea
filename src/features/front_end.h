// From pixels to what the mapper sees.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "features/extractor.h"
#include "frame.h"

namespace eifmap {

// What a frame says about itself, apart from its features and its camera's calibration.
struct FrameHeader {
  std::int64_t time_us = 0;
  std::int64_t publisher = 0;
  std::int64_t seq = -1;
  std::string camera;
};

// Of an image whose features nobody looks for.
FeatureFrame frame_without_features(const FeatureExtractor& extractor, const Camera& camera,
                                    const FrameHeader& header);

// `gray` and what is thrown: as FeatureExtractor::extract.
FeatureFrame extract_frame(FeatureExtractor& extractor, const cv::Mat& gray, const Camera& camera,
                           const FrameHeader& header);

}  // namespace eifmap
