// Images with truth, and the features made of them once for all runs.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "features/extractor.h"
#include "frame.h"
#include "geometry/camera.h"
#include "sequence/tum.h"

namespace eifmap::test {

struct Recording {
  std::string name;
  Camera camera;
  std::vector<std::int64_t> times_us;  // of the images
  std::vector<TumPose> truth;          // by time
  // Not measured but made: a pose for every image, which its covariance can be judged by.
  bool truth_is_exact = false;
  std::function<cv::Mat(int)> image;  // gray; throws std::runtime_error when it cannot be read

  int size() const { return static_cast<int>(times_us.size()); }
};

// "courtyard" is rendered, others are folders in `data`, and nothing when not there. At most
// `max_frames` images, 0: all. Throws std::runtime_error on a folder that cannot be read.
std::optional<Recording> open_recording(const std::string& name, const std::filesystem::path& data,
                                        int max_frames);

struct FeatureSet {
  std::vector<FeatureFrame> frames;
  double cpu_ms = 0;  // for a frame, on average, in one thread
};

// `images`: of the recording, all; every n-th is taken.
FeatureSet extract_features(const Recording& recording, const std::vector<cv::Mat>& images,
                            const FeatureOptions& options, int every);

}  // namespace eifmap::test
