#include "simulation/simulated_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>

#include "simulation/block.h"
#include "simulation/corridor.h"
#include "simulation/mishap.h"
#include "simulation/motion.h"
#include "simulation/moving_object.h"
#include "simulation/renderer.h"
#include "simulation/scenery.h"
#include "simulation/value_noise.h"
#include "simulation/vga_camera.h"

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

// Where what can be done.
struct Place {
  const char* world;
  std::array<const char*, 6> motions;
};
constexpr std::array<Place, 6> kPlaces{
    {{"courtyard", {"lap", "turn", "look_around", "pause", "standstill", "pan"}},
     {"tiles", {"lap", "turn", "look_around", "pause", "standstill", "pan"}},
     {"block", {"lap", "standstill", "pan"}},
     {"corridor", {"walk", "standstill", "pan"}},
     {"wall", {"sideways", "standstill", "pan"}},
     {"street", {"drive", "sideways", "standstill", "pan"}}}};

constexpr double kDegree = std::numbers::pi / 180;

Motion walk_motion(const SimulationOptions& options, Walk walk) {
  if (options.speed > 0) walk.speed = options.speed;
  walk.roll = options.roll_deg * kDegree;
  return walking(walk);
}

Motion make_motion(const SimulationOptions& options, const Scenery& scenery) {
  constexpr double kFrom = 5, kPause = 20, kLook = 8;  // s
  constexpr double kAngle = -100 * kDegree;  // to the left: off what a walk has seen before
  const auto speed = [&options](double usual) { return options.speed > 0 ? options.speed : usual; };
  const std::string& motion = options.motion;
  if (motion == "standstill") return standing(scenery.across);
  if (motion == "pan") return panning(scenery.across, kAngle, kLook);
  if (motion == "drive") return driving(scenery.along, speed(4));
  if (motion == "sideways") return moving_sideways(scenery.across, speed(0.5));
  if (options.world == "block") return drive_round_the_block(speed(5.6));
  if (motion == "walk") return walk_motion(options, walk_down_the_corridor());
  Walk walk;
  walk.path = motion == "turn" ? Path::kRectangle : Path::kEllipse;
  const Motion lap = walk_motion(options, walk);
  if (motion == "pause") return with_pause(lap, kFrom, kPause);
  if (motion == "look_around") return with_look_around(lap, kFrom, kLook, kAngle);
  return lap;
}

Motion make_motion_with_event(const SimulationOptions& o, const Scenery& scenery) {
  const Motion motion = make_motion(o, scenery);
  if (o.event != "kidnapped") return motion;
  return with_carrying(motion, o.event_from_s, o.event_for_s, o.event_to_s);
}

std::string problem_of_motion(const SimulationOptions& options) {
  std::string worlds;
  for (const Place& place : kPlaces) {
    if (options.world != place.world) {
      worlds += (worlds.empty() ? "" : ", ") + std::string(place.world);
      continue;
    }
    std::string motions;
    for (const char* motion : place.motions) {
      if (!motion) break;
      if (options.motion == motion) return "";
      motions += (motions.empty() ? "" : ", ") + std::string(motion);
    }
    return "simulation: motion is '" + options.motion + "', in the world " + options.world +
           " it is one of " + motions;
  }
  return "simulation: world is '" + options.world + "', wanted one of " + worlds;
}

std::string problem_of_event(const SimulationOptions& options) {
  const std::string& event = options.event;
  if (event != "none" && event != "black" && event != "covered" && event != "bus" &&
      event != "kidnapped")
    return "simulation: event is '" + event + "', wanted none, black, covered, bus or kidnapped";
  if (event == "bus" && options.world != "street")
    return "simulation: a bus drives in the world street alone";
  if (event == "kidnapped" && (options.motion == "standstill" || options.motion == "pan"))
    return "simulation: a camera is kidnapped on its way, and motion " + options.motion +
           " has none: choose another motion";
  if (!(options.event_to_s >= 0 && options.event_to_s <= 100000))
    return "simulation: event_to_s must be 0 to 100000";
  if (!std::isfinite(options.event_from_s) || !(options.event_for_s > 0))
    return "simulation: event_from_s must be a number and event_for_s above 0";
  return "";
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
  if (std::string wrong = problem_of_motion(*this); !wrong.empty()) return wrong;
  if (std::string wrong = problem_of_event(*this); !wrong.empty()) return wrong;
  if (!(speed >= 0 && speed <= 100)) return "simulation: speed must be 0 to 100 m/s";
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
  Scenery scenery;
  Motion motion;
  std::vector<Surface> surfaces;
  Renderer renderer;
  SensorNoise noise;
  std::optional<MovingObject> bus_passing;

  explicit State(const SimulationOptions& o)
      : options(o),
        camera(make_camera(o)),
        scenery(make_scenery(o.world, static_cast<std::uint32_t>(o.seed))),
        motion(make_motion_with_event(o, scenery)),
        surfaces(paint(scenery.quads, scenery.light)),
        renderer(camera, surfaces),
        noise(o.noise, o.seed) {
    if (o.event != "bus") return;
    const double middle = std::max(0.0, o.event_from_s + o.event_for_s / 2);
    const Rigid3 view(scenery.across.rotation, motion(middle).translation);
    bus_passing.emplace(camera, bus(static_cast<std::uint32_t>(o.seed)), scenery.light,
                        bus_ride(view, o.event_from_s, o.event_for_s, o.seed % 2 == 0));
  }

  bool during_event(double seconds) const {
    return seconds >= options.event_from_s && seconds < options.event_from_s + options.event_for_s;
  }

  // Before the sensor's noise.
  Rendering render(double seconds) const {
    const Rigid3 pose = motion(seconds);
    Rendering rendering = renderer.render(pose);
    if (bus_passing) bus_passing->draw_into(rendering, pose, seconds);
    if (!during_event(seconds)) return rendering;
    if (options.event == "black" || options.event == "kidnapped") black_out(rendering.gray);
    if (options.event == "covered") cover_right_half(rendering.gray);
    return rendering;
  }

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
  return state_->motion(i / state_->options.rate_hz);
}

cv::Mat SimulatedWorld::render(int i) const {
  state_->check(i);
  cv::Mat gray = state_->render(i / state_->options.rate_hz).gray;
  state_->noise.add(gray, i);
  cv::Mat image;
  gray.convertTo(image, CV_8U);  // rounds and saturates
  return image;
}

cv::Mat SimulatedWorld::depth(int i) const {
  state_->check(i);
  const cv::Mat inverse = state_->render(i / state_->options.rate_hz).inverse_depth;
  cv::Mat depth(inverse.size(), CV_32FC1);
  for (int y = 0; y < inverse.rows; ++y)
    for (int x = 0; x < inverse.cols; ++x) {
      const float d = inverse.at<float>(y, x);
      depth.at<float>(y, x) = d > 0 ? 1 / d : 0;
    }
  return depth;
}

}  // namespace eifmap
