// Features made once for all runs over a recording.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "consistency/recording.h"
#include "features/extractor.h"
#include "frame.h"

namespace eifmap::test {

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
