#include "features/front_end.h"

namespace eifmap {

FeatureFrame frame_without_features(const FeatureExtractor& extractor, const Camera& camera,
                                    const FrameHeader& header) {
  FeatureFrame frame;
  frame.time_us = header.time_us;
  frame.publisher = header.publisher;
  frame.seq = header.seq;
  frame.camera = header.camera;
  frame.calibration_id = camera.id();
  frame.width = camera.width;
  frame.height = camera.height;
  frame.extractor = extractor.id();
  return frame;
}

FeatureFrame extract_frame(FeatureExtractor& extractor, const cv::Mat& gray, const Camera& camera,
                           const FrameHeader& header) {
  Features features = extractor.extract(gray, camera);
  FeatureFrame frame = frame_without_features(extractor, camera, header);
  frame.width = gray.cols;
  frame.height = gray.rows;
  frame.keypoints = std::move(features.keypoints);
  frame.descriptors = std::move(features.descriptors);
  return frame;
}

}  // namespace eifmap
