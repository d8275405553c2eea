#include "ablation/features_of.h"

#include <algorithm>

#include "features/front_end.h"
#include "support/thread_cpu.h"

namespace eifmap::test {

std::optional<Recording> open_recording(const std::string& name, const std::filesystem::path& data,
                                        int max_frames) {
  if (name == "courtyard") {
    SimulationOptions options;
    if (max_frames > 0) options.num_frames = std::min(options.num_frames, max_frames);
    return rendered(options);
  }
  if (!std::filesystem::exists(data / name)) return std::nullopt;
  return recorded(data / name, max_frames);
}

FeatureSet extract_features(const Recording& recording, const std::vector<cv::Mat>& images,
                            const FeatureOptions& options, int every) {
  FeatureSet set;
  FeatureExtractor extractor(options);
  const double begin = thread_cpu_seconds();
  for (int i = 0; i < recording.size(); i += every)
    set.frames.push_back(extract_frame(extractor, images[i], recording.camera,
                                       {recording.times_us[i], 0, i, "cam0"}));
  set.cpu_ms = 1000 * (thread_cpu_seconds() - begin) /
               static_cast<double>(std::max<size_t>(1, set.frames.size()));
  return set;
}

}  // namespace eifmap::test
