#include "simulation/simulated_world.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "simulation/courtyard.h"
#include "simulation/renderer.h"
#include "simulation/value_noise.h"
#include "simulation/vga_camera.h"
#include "simulation/walk.h"

namespace eifmap {
namespace {

using namespace simulation;

Camera make_camera(const SimulationOptions& options) {
  Camera camera = vga_camera(470);
  if (options.distorted) {
    camera.model = CameraModel::kRadialTangential;
    camera.distortion = {-0.28, 0.07, 0.0002, -0.0001, 0};
  }
  if (options.fisheye) {
    camera.fx = camera.fy = 305;
    camera.model = CameraModel::kFisheye;
    camera.distortion = {-0.013, 0.004, -0.001, 0.0002, 0};
  }
  return camera;
}

Walk make_walk(const SimulationOptions& options) {
  Walk walk;
  walk.path = options.motion == "turn" ? Path::kRectangle : Path::kEllipse;
  walk.roll = options.roll_deg * std::numbers::pi / 180;
  return walk;
}

// Gaussian noise drawn once; each image row starts at its own place in it.
class SensorNoise {
 public:
  SensorNoise(double sigma, int seed) : seed_(static_cast<std::uint32_t>(seed)), values_(kSize) {
    std::mt19937 random(seed_);
    std::normal_distribution<float> normal(0, 1);
    for (float& value : values_) value = static_cast<float>(sigma) * normal(random);
  }

  void add(cv::Mat& gray, int frame) const {
    for (int y = 0; y < gray.rows; ++y) {
      const std::size_t start =
          hash_cell(frame, y, seed_) % (kSize - static_cast<std::size_t>(gray.cols));
      float* row = gray.ptr<float>(y);
      for (int x = 0; x < gray.cols; ++x) row[x] += values_[start + static_cast<std::size_t>(x)];
    }
  }

 private:
  static constexpr std::size_t kSize = 1 << 20;
  std::uint32_t seed_;
  std::vector<float> values_;
};

}  // namespace

std::string SimulationOptions::problem() const {
  if (world != "courtyard") return "simulation: world is '" + world + "', wanted 'courtyard'";
  if (motion != "lap" && motion != "turn")
    return "simulation: motion is '" + motion + "', wanted 'lap' or 'turn'";
  if (!(roll_deg >= 0 && roll_deg <= 180)) return "simulation: roll_deg must be 0 to 180";
  if (num_frames < 1 || num_frames > 100000) return "simulation: num_frames must be 1 to 100000";
  if (!(rate_hz >= 1 && rate_hz <= 1000)) return "simulation: rate_hz must be 1 to 1000";
  if (distorted && fisheye) return "simulation: distorted and fisheye are two lenses; choose one";
  if (!(noise >= 0 && noise <= 50)) return "simulation: noise must be 0 to 50 gray levels";
  if (seed < 0) return "simulation: seed must be 0 or more";
  return "";
}

struct SimulatedWorld::State {
  SimulationOptions options;
  Camera camera;
  Walk walk;
  std::vector<Surface> surfaces;
  Renderer renderer;
  SensorNoise noise;

  explicit State(const SimulationOptions& o)
      : options(o),
        camera(make_camera(o)),
        walk(make_walk(o)),
        surfaces(paint(courtyard(static_cast<std::uint32_t>(o.seed)), courtyard_light())),
        renderer(camera, surfaces),
        noise(o.noise, o.seed) {}

  void check(int i) const {
    if (i < 0 || i >= options.num_frames)
      throw std::out_of_range("simulation: frame " + std::to_string(i) + " of " +
                              std::to_string(options.num_frames));
  }
};

SimulatedWorld::SimulatedWorld(const SimulationOptions& options) {
  if (const auto problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  state_ = std::make_unique<State>(options);
}
SimulatedWorld::~SimulatedWorld() = default;
SimulatedWorld::SimulatedWorld(SimulatedWorld&&) noexcept = default;
SimulatedWorld& SimulatedWorld::operator=(SimulatedWorld&&) noexcept = default;

int SimulatedWorld::num_frames() const {
  return state_->options.num_frames;
}
const Camera& SimulatedWorld::camera() const {
  return state_->camera;
}

std::int64_t SimulatedWorld::time_us(int i) const {
  state_->check(i);
  return 1000000 + std::llround(i * 1e6 / state_->options.rate_hz);
}

Rigid3 SimulatedWorld::world_from_camera(int i) const {
  state_->check(i);
  return state_->walk.world_from_camera(i / state_->options.rate_hz);
}

cv::Mat SimulatedWorld::render(int i) const {
  cv::Mat gray = state_->renderer.render(world_from_camera(i)).gray;
  state_->noise.add(gray, i);
  cv::Mat image;
  gray.convertTo(image, CV_8U);  // rounds and saturates
  return image;
}

cv::Mat SimulatedWorld::depth(int i) const {
  const cv::Mat inverse = state_->renderer.render(world_from_camera(i)).inverse_depth;
  cv::Mat depth(inverse.size(), CV_32FC1);
  for (int y = 0; y < inverse.rows; ++y)
    for (int x = 0; x < inverse.cols; ++x) {
      const float d = inverse.at<float>(y, x);
      depth.at<float>(y, x) = d > 0 ? 1 / d : 0;
    }
  return depth;
}

}  // namespace eifmap
