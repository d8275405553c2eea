#include "ablation/recording.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "features/front_end.h"
#include "sequence/recorded_sequence.h"
#include "simulation/simulated_world.h"
#include "support/thread_cpu.h"

namespace eifmap::test {
namespace {

double seconds(std::int64_t time_us) {
  return 1e-6 * static_cast<double>(time_us);
}

Recording rendered_courtyard(int max_frames) {
  SimulationOptions options;
  if (max_frames > 0) options.num_frames = std::min(options.num_frames, max_frames);
  const auto world = std::make_shared<const SimulatedWorld>(options);
  Recording recording;
  recording.name = "courtyard";
  recording.camera = world->camera();
  recording.truth_is_exact = true;
  for (int i = 0; i < world->num_frames(); ++i) {
    recording.times_us.push_back(world->time_us(i));
    recording.truth.push_back({seconds(world->time_us(i)), world->world_from_camera(i)});
  }
  recording.image = [world](int i) { return world->render(i); };
  return recording;
}

Recording recorded(const std::string& name, const std::filesystem::path& folder, int max_frames) {
  RecordedSequence::Opened opened = RecordedSequence::open(folder);
  if (!opened.sequence) throw std::runtime_error(opened.problem);
  const auto sequence = std::make_shared<const RecordedSequence>(std::move(*opened.sequence));
  Recording recording;
  recording.name = name;
  recording.camera = sequence->camera();
  recording.truth = sequence->ground_truth();
  const int size = max_frames > 0 ? std::min(max_frames, sequence->size()) : sequence->size();
  for (int i = 0; i < size; ++i) recording.times_us.push_back(sequence->time_us(i));
  recording.image = [sequence](int i) {
    GrayImage image = sequence->load_gray(i);
    if (!image.problem.empty()) throw std::runtime_error(image.problem);
    return std::move(image.image);
  };
  return recording;
}

}  // namespace

std::optional<Recording> open_recording(const std::string& name, const std::filesystem::path& data,
                                        int max_frames) {
  if (name == "courtyard") return rendered_courtyard(max_frames);
  if (!std::filesystem::exists(data / name)) return std::nullopt;
  return recorded(name, data / name, max_frames);
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
