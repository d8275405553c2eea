#include "consistency/frame_source.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "features/front_end.h"
#include "options.h"
#include "sequence/recorded_sequence.h"
#include "simulation/feature_world.h"
#include "simulation/random.h"
#include "simulation/simulated_world.h"

namespace eifmap::test {
namespace {

class FeatureSource : public FrameSource {
 public:
  FeatureSource(const SourceOptions& options, int seed) : world_(world_options(options, seed)) {}
  int size() const override { return world_.num_frames(); }
  const Camera& camera() const override { return world_.camera(); }
  std::int64_t time_us(int i) const override { return world_.time_us(i); }
  std::optional<Rigid3> world_from_camera(int i) const override {
    return world_.world_from_camera(i);
  }
  FeatureFrame frame(int i) const override { return world_.frame(i).frame; }

 private:
  static FeatureWorldOptions world_options(const SourceOptions& options, int seed) {
    FeatureWorldOptions world;
    world.motion = options.world;
    world.num_frames = options.world == "loop" ? 288 : 120;
    if (options.frames > 0) world.num_frames = options.frames;
    world.noise_px = options.noise_px;
    world.sigma_px = options.noise_px / MapperOptions().sigma_factor;
    world.drift_px = options.drift_px;
    world.wrong_share = options.wrong_share;
    world.seed = seed;
    return world;
  }

  FeatureWorld world_;
};

class RenderedSource : public FrameSource {
 public:
  RenderedSource(const SourceOptions& options, int seed) : world_(world_options(options, seed)) {
    if (options.cache.empty()) return;
    folder_ = options.cache / (options.world + std::to_string(seed));
    std::filesystem::create_directories(folder_);
  }
  int size() const override { return world_.num_frames(); }
  const Camera& camera() const override { return world_.camera(); }
  std::int64_t time_us(int i) const override { return world_.time_us(i); }
  std::optional<Rigid3> world_from_camera(int i) const override {
    return world_.world_from_camera(i);
  }
  FeatureFrame frame(int i) const override {
    return extract_frame(extractor_, image(i), camera(), {time_us(i), 1, i, "cam0"});
  }

 private:
  static SimulationOptions world_options(const SourceOptions& options, int seed) {
    SimulationOptions world;
    world.motion = options.world;
    if (options.frames > 0) world.num_frames = options.frames;
    world.seed = seed;
    return world;
  }

  cv::Mat image(int i) const {
    if (folder_.empty()) return world_.render(i);
    const std::string file = (folder_ / (std::to_string(i) + ".png")).string();
    if (std::filesystem::exists(file)) return cv::imread(file, cv::IMREAD_GRAYSCALE);
    const cv::Mat image = world_.render(i);
    cv::imwrite(file, image, {cv::IMWRITE_PNG_COMPRESSION, 1});
    return image;
  }

  SimulatedWorld world_;
  mutable FeatureExtractor extractor_;
  std::filesystem::path folder_;
};

class RecordedSource : public FrameSource {
 public:
  RecordedSource(const SourceOptions& options, int seed) : seed_(seed) {
    RecordedSequence::Opened opened = RecordedSequence::open(options.world);
    if (!opened.sequence) throw std::runtime_error(opened.problem);
    sequence_.emplace(std::move(*opened.sequence));
    frames_ = options.frames > 0 ? std::min(options.frames, sequence_->size()) : sequence_->size();
  }
  int size() const override { return frames_; }
  const Camera& camera() const override { return sequence_->camera(); }
  std::int64_t time_us(int i) const override { return sequence_->time_us(i); }
  std::optional<Rigid3> world_from_camera(int i) const override {
    constexpr double kSameTime = 1e-3;  // s
    for (const TumPose& pose : sequence_->ground_truth())
      if (std::abs(pose.time_s - 1e-6 * static_cast<double>(time_us(i))) < kSameTime)
        return pose.world_from_camera;
    return std::nullopt;
  }
  FeatureFrame frame(int i) const override {
    const GrayImage image = sequence_->load_gray(i);
    if (!image.problem.empty()) throw std::runtime_error(image.problem);
    FeatureFrame frame =
        extract_frame(extractor_, image.image, camera(), {time_us(i), 1, i, "cam0"});
    if (seed_ > 0) jitter(frame, i);
    return frame;
  }

 private:
  void jitter(FeatureFrame& frame, int i) const {
    simulation::Random random(static_cast<std::uint64_t>(1'000'003 * seed_ + i));
    constexpr double kJitter = 0.05;  // px
    for (Keypoint& keypoint : frame.keypoints) {
      const auto move = [&random](float x, int side) {
        return static_cast<float>(std::clamp(x + kJitter * random.normal(), -0.5, side - 0.5));
      };
      keypoint.u = move(keypoint.u, frame.width);
      keypoint.v = move(keypoint.v, frame.height);
    }
  }

  int seed_, frames_ = 0;
  std::optional<RecordedSequence> sequence_;
  mutable FeatureExtractor extractor_;
};

}  // namespace

std::unique_ptr<FrameSource> make_source(const SourceOptions& options, int seed) {
  if (options.world == "sideways" || options.world == "forward" || options.world == "loop")
    return std::make_unique<FeatureSource>(options, seed);
  if (options.world == "lap" || options.world == "turn")
    return std::make_unique<RenderedSource>(options, seed);
  return std::make_unique<RecordedSource>(options, seed);
}

}  // namespace eifmap::test
