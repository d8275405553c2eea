#include "features/front_end.h"

namespace eifmap {

FeatureFrame extract_frame(const SurfExtractor& extractor, const cv::Mat& gray,
                           const FrameHeader& header) {
  Features features = extractor.extract(gray);
  FeatureFrame frame;
  frame.time_us = header.time_us;
  frame.publisher = header.publisher;
  frame.seq = header.seq;
  frame.camera = header.camera;
  frame.calibration_id = header.calibration_id;
  frame.width = gray.cols;
  frame.height = gray.rows;
  frame.keypoints = std::move(features.keypoints);
  frame.descriptors = std::move(features.descriptors);
  return frame;
}

}  // namespace eifmap
