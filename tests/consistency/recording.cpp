#include "consistency/recording.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "sequence/recorded_sequence.h"

namespace eifmap::test {
namespace {

double seconds(std::int64_t time_us) {
  return 1e-6 * static_cast<double>(time_us);
}

cv::Mat kept(const std::filesystem::path& folder, int i, const SimulatedWorld& world) {
  if (folder.empty()) return world.render(i);
  const std::string file = (folder / (std::to_string(i) + ".png")).string();
  if (std::filesystem::exists(file)) return cv::imread(file, cv::IMREAD_GRAYSCALE);
  const cv::Mat image = world.render(i);
  cv::imwrite(file, image, {cv::IMWRITE_PNG_COMPRESSION, 1});
  return image;
}

}  // namespace

std::optional<Rigid3> Recording::world_from_camera(int i) const {
  constexpr double kSameTime = 1e-3;  // s
  for (const TumPose& pose : truth)
    if (std::abs(pose.time_s - seconds(times_us[static_cast<std::size_t>(i)])) < kSameTime)
      return pose.world_from_camera;
  return std::nullopt;
}

Recording rendered(const SimulationOptions& options, const std::filesystem::path& cache) {
  const auto world = std::make_shared<const SimulatedWorld>(options);
  Recording recording;
  recording.name = options.world;
  recording.camera = world->camera();
  recording.truth_is_exact = true;
  for (int i = 0; i < world->num_frames(); ++i) {
    recording.times_us.push_back(world->time_us(i));
    recording.truth.push_back({seconds(world->time_us(i)), world->world_from_camera(i)});
  }
  const std::filesystem::path folder =
      cache.empty() ? cache
                    : cache / (options.world + '_' + options.motion + '_' + options.event + '_' +
                               std::to_string(options.seed));
  if (!folder.empty()) std::filesystem::create_directories(folder);
  recording.image = [world, folder](int i) { return kept(folder, i, *world); };
  return recording;
}

Recording recorded(const std::filesystem::path& folder, int max_frames) {
  RecordedSequence::Opened opened = RecordedSequence::open(folder);
  if (!opened.sequence) throw std::runtime_error(opened.problem);
  const auto sequence = std::make_shared<const RecordedSequence>(std::move(*opened.sequence));
  Recording recording;
  recording.name = folder.filename().string();
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

}  // namespace eifmap::test
