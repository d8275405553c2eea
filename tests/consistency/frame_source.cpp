#include "consistency/frame_source.h"

#include <map>
#include <utility>

#include "consistency/recording.h"
#include "consistency/trajectory_world.h"
#include "features/front_end.h"
#include "options.h"
#include "server/jitter.h"
#include "simulation/feature_world.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

class FeatureSource : public FrameSource {
 public:
  FeatureSource(const SourceOptions& options, int seed)
      : world_(world_options(options, seed)), camera_(world_.camera()) {
    if (options.calibration_off == 0) return;
    const MeasurementOptions sigmas;
    Random random(static_cast<std::uint64_t>(seed) * 31 + 7);
    const auto draw = [&](double sigma) {
      return options.calibration_off * sigma * random.normal();
    };
    const double focal = 1 + draw(sigmas.focal_sigma);
    camera_.fx *= focal;
    camera_.fy *= focal;
    camera_.cx += draw(sigmas.centre_sigma_px);
    camera_.cy += draw(sigmas.centre_sigma_px);
    camera_.distortion[0] += draw(sigmas.radial_sigma);
  }
  int size() const override { return world_.num_frames(); }
  const Camera& camera() const override { return camera_; }
  std::int64_t time_us(int i) const override { return world_.time_us(i); }
  std::optional<Rigid3> world_from_camera(int i) const override {
    return world_.world_from_camera(i);
  }
  FeatureFrame frame(int i) const override {
    FeatureFrame frame = world_.frame(i).frame;
    frame.calibration_id = camera_.id();
    return frame;
  }
  std::optional<int> point_at(std::int64_t time_us, float u, float v) const override {
    if (time_us != time_of_seen_us_) {
      int i = 0;
      while (world_.time_us(i) != time_us) ++i;
      seen_ = world_.frame(i);
      time_of_seen_us_ = time_us;
    }
    for (std::size_t k = 0; k < seen_.point.size(); ++k)
      if (seen_.frame.keypoints[k].u == u && seen_.frame.keypoints[k].v == v) return seen_.point[k];
    return std::nullopt;
  }
  std::optional<Eigen::Vector3d> point(int which) const override {
    return world_.points().at(static_cast<std::size_t>(which));
  }

 private:
  static FeatureWorldOptions world_options(const SourceOptions& options, int seed) {
    FeatureWorldOptions world;
    world.motion = options.world;
    world.num_frames = options.world == "loop" ? 288 : 120;
    if (options.frames > 0) world.num_frames = options.frames;
    world.noise_px = options.noise_px;
    world.sigma_px = options.noise_px / options.noise_ratio / MapperOptions().sigma_factor;
    world.drift_px = options.drift_px;
    world.wrong_share = options.wrong_share;
    world.seed = seed;
    return world;
  }

  FeatureWorld world_;
  Camera camera_;                   // as the mapper is told
  mutable SimulatedFeatures seen_;  // the frame that was asked about last
  mutable std::int64_t time_of_seen_us_ = -1;
};

// The features of images, extracted in order, each once: what extracts may follow the camera.
class ImageSource : public FrameSource {
 public:
  // `seed`: of the noise added to the keypoints; 0: none. `kept`: what is extracted is, for those
  // who go through it again.
  ImageSource(Recording recording, int seed, bool kept)
      : recording_(std::move(recording)),
        kept_(kept),
        jitter_(seed > 0 ? kJitterPx : 0, static_cast<std::uint64_t>(seed)) {}
  int size() const override { return recording_.size(); }
  const Camera& camera() const override { return recording_.camera; }
  std::int64_t time_us(int i) const override {
    return recording_.times_us[static_cast<std::size_t>(i)];
  }
  std::optional<Rigid3> world_from_camera(int i) const override {
    return recording_.world_from_camera(i);
  }
  bool goes_again() const override { return kept_; }
  FeatureFrame frame(int i) const override {
    const auto known = frames_.find(i);
    if (known != frames_.end()) return known->second;
    FeatureFrame frame =
        extract_frame(extractor_, recording_.image(i), camera(), {time_us(i), 1, i, "cam0"});
    jitter_.apply(frame);
    if (kept_) frames_[i] = frame;
    return frame;
  }

 private:
  Recording recording_;
  bool kept_;
  mutable std::map<int, FeatureFrame> frames_;
  mutable FeatureExtractor extractor_;
  mutable Jitter jitter_;
};

// Of the rendered worlds; nothing of others.
std::optional<SimulationOptions> rendered_world(const SourceOptions& options, int seed) {
  SimulationOptions world;
  if (options.world == "tiles")
    world.world = "tiles";
  else if (options.world == "block")
    world.world = "block", world.num_frames = 600;
  else if (options.world == "rendered_corridor")
    world.world = "corridor", world.motion = "walk";
  else if (options.world == "lap" || options.world == "turn")
    world.motion = options.world;
  else
    return std::nullopt;
  if (options.frames > 0) world.num_frames = options.frames;
  world.event = options.event;
  world.seed = seed;
  return world;
}

}  // namespace

std::unique_ptr<FrameSource> make_source(const SourceOptions& options, int seed) {
  if (options.world == "sideways" || options.world == "forward" || options.world == "loop")
    return std::make_unique<FeatureSource>(options, seed);
  if (const auto world = rendered_world(options, seed))
    return std::make_unique<ImageSource>(rendered(*world, options.cache), 0, true);
  const bool straight = options.world == "street" || options.world == "corridor";
  if (straight || options.world.ends_with(".txt")) {
    TrajectoryWorldOptions world;
    world.max_frames = options.frames;
    world.noise_px = options.noise_px;
    world.noise_ratio = options.noise_ratio;
    world.wrong_share = options.wrong_share;
    world.seed = seed;
    if (!straight) return std::make_unique<TrajectoryWorld>(options.world, world);
    if (options.frames == 0) world.max_frames = 400;
    if (options.world == "corridor") world.period = 40, world.range = 37, world.points_per_m = 40;
    return std::make_unique<TrajectoryWorld>(world);
  }
  return std::make_unique<ImageSource>(recorded(options.world, options.frames), seed, false);
}

}  // namespace eifmap::test
