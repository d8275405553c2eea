#include "simulation/feature_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "simulation/random.h"
#include "simulation/vga_camera.h"

namespace eifmap {
namespace {

using Eigen::Vector3d;
using simulation::Random;

constexpr double kStep = 0.12;  // m from frame to frame
constexpr double kRadius = 5;   // m, of the loop
constexpr double kSight = 25;   // m that one looks ahead

// The middle of the way, and where it leads; a camera on it looks along its z.
Rigid3 way(const std::string& motion, double length) {
  if (motion == "sideways") return {so3_exp({0, 0, 0}), {length, 0, 0}};
  if (motion == "forward") return {so3_exp({0, 0, 0}), {0, 0, length}};
  const double angle = length / kRadius;  // to the left: y is down
  return {so3_exp({0, -angle - 0.25, 0}),
          {kRadius * (std::cos(angle) - 1), 0, kRadius * std::sin(angle)}};
}

// A point that can be seen from somewhere on the way.
Vector3d draw_point(const FeatureWorldOptions& options, Random& random) {
  const double length = kStep * options.num_frames;
  if (options.motion == "sideways")
    return {random.uniform(-8, length + 8), random.uniform(-5, 5), random.uniform(4, 10)};
  const auto wall = [&random] {  // across the corridor, beside and above the camera
    const double side = random.uniform() < 0.5 ? -1 : 1;
    return random.uniform() < 0.7
               ? Eigen::Vector2d(side * random.uniform(1.5, 4), random.uniform(-3, 3))
               : Eigen::Vector2d(random.uniform(-4, 4), side * random.uniform(1.2, 3));
  };
  const Eigen::Vector2d across = wall();
  if (options.motion == "forward")
    return {across.x(), across.y(), random.uniform(1, length + kSight)};
  const double angle = random.uniform(0, 2 * std::numbers::pi), radius = kRadius + across.x();
  return {radius * std::cos(angle) - kRadius, across.y(), radius * std::sin(angle)};
}

// Points for one image, times how often the way's end is out of sight of its start.
int number_of_points(const FeatureWorldOptions& options) {
  const double length = kStep * options.num_frames;
  if (options.motion == "sideways") return static_cast<int>(options.features * (length + 16) / 6);
  if (options.motion == "forward") return static_cast<int>(options.features * (length + 25) / 12);
  return options.features * 14;
}

// A point's own properties come from its number.
int sign_of(int point) {
  return point % 2 == 0 ? 1 : -1;
}
float response_of(int point) {
  return 1 / static_cast<float>(point + 1);
}

// A few of the keypoints of each sign pass their looks round.
std::vector<int> looks_of(const std::vector<int>& points, double wrong_share, Random& random) {
  std::vector<int> looks = points;
  for (const int sign : {1, -1}) {
    std::vector<std::size_t> wrong;
    for (std::size_t k = 0; k < points.size(); ++k)
      if (random.uniform() < wrong_share && sign_of(points[k]) == sign) wrong.push_back(k);
    for (std::size_t n = 0; n < wrong.size(); ++n)
      looks[wrong[n]] = points[wrong[(n + 1) % wrong.size()]];
  }
  return looks;
}

}  // namespace

Camera feature_world_camera() {
  return simulation::vga_camera(500);
}

std::string FeatureWorldOptions::problem() const {
  if (motion != "sideways" && motion != "forward" && motion != "loop")
    return "feature world: motion is '" + motion + "', wanted sideways, forward or loop";
  if (num_frames < 1 || num_frames > 1000000)
    return "feature world: num_frames must be 1 to 1000000";
  if (!(rate_hz >= 1 && rate_hz <= 1000)) return "feature world: rate_hz must be 1 to 1000";
  if (features < 1 || features > 10000) return "feature world: features must be 1 to 10000";
  if (!(noise_px >= 0 && noise_px <= 100)) return "feature world: noise_px must be 0 to 100";
  if (!(sigma_px > 0 && sigma_px <= 100)) return "feature world: sigma_px must be in (0, 100]";
  if (!(drift_px >= 0 && drift_px <= 100)) return "feature world: drift_px must be 0 to 100";
  if (!(drift_angle_deg > 0 && drift_angle_deg <= 180))
    return "feature world: drift_angle_deg must be in (0, 180]";
  if (!(repeatability >= 0 && repeatability <= 1))
    return "feature world: repeatability must be 0 to 1";
  if (!(wrong_share >= 0 && wrong_share <= 1)) return "feature world: wrong_share must be 0 to 1";
  if (max_features < 1) return "feature world: max_features must be 1 or more";
  if (seed < 0) return "feature world: seed must be 0 or more";
  return "";
}

FeatureWorld::FeatureWorld(const FeatureWorldOptions& options)
    : options_(options), camera_(feature_world_camera()) {
  if (const auto problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  Random random(static_cast<std::uint64_t>(options.seed));
  const int number = number_of_points(options);
  for (int k = 0; k < number; ++k) {
    points_.push_back(draw_point(options, random));
    size_.push_back(0.01 * std::exp(random.uniform(0, 3)));
    const Eigen::Matrix<double, kDescriptorSize, 1> looks =
        254 * random.normal_vector<kDescriptorSize>().normalized();
    for (const double x : looks)
      descriptors_.push_back(static_cast<std::int8_t>(std::lround(std::clamp(x, -127.0, 127.0))));
  }
}

void FeatureWorld::check(int i) const {
  if (i < 0 || i >= num_frames())
    throw std::out_of_range("feature world: frame " + std::to_string(i) + " of " +
                            std::to_string(num_frames()));
}

std::int64_t FeatureWorld::time_us(int i) const {
  check(i);
  return 1000000 + std::llround(i * 1e6 / options_.rate_hz);
}

Rigid3 FeatureWorld::world_from_camera(int i) const {
  check(i);
  const Rigid3 middle = way(options_.motion, kStep * i);
  const Vector3d sway(0.05 * std::sin(0.21 * i), 0.04 * std::sin(0.37 * i + 1),
                      0.03 * std::sin(0.29 * i + 2));
  const Vector3d shake(0.03 * std::sin(0.17 * i), 0.05 * std::sin(0.13 * i + 1),
                       0.04 * std::sin(0.11 * i + 2));
  return middle * Rigid3(so3_exp(shake), sway);
}

// A smooth random function of the viewing direction, of a point's own: a few random waves, whose
// sum is close to a Gaussian process with a squared-exponential covariance (A. Rahimi, B. Recht,
// NIPS 2007).
Eigen::Vector2d FeatureWorld::drift(int point, const Vector3d& camera_centre) const {
  if (options_.drift_px == 0) return Eigen::Vector2d::Zero();
  constexpr int kWaves = 8;
  Random random(static_cast<std::uint64_t>(options_.seed) * 7'919 +
                static_cast<std::uint64_t>(point));
  const Vector3d direction = (points_[point] - camera_centre).normalized();
  const double per_radian = 180 / (std::numbers::pi * options_.drift_angle_deg);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int wave = 0; wave < kWaves; ++wave) {
    const double phase = per_radian * random.normal_vector<3>().dot(direction) +
                         random.uniform(0, 2 * std::numbers::pi);
    const double way = random.uniform(0, 2 * std::numbers::pi);
    sum += std::cos(phase) * Eigen::Vector2d(std::cos(way), std::sin(way));
  }
  return options_.drift_px * std::sqrt(4.0 / kWaves) * sum;
}

SimulatedFeatures FeatureWorld::frame(int i) const {
  Random random(static_cast<std::uint64_t>(options_.seed) * 1'000'003 +
                static_cast<std::uint64_t>(i) + 1);
  const Vector3d centre = world_from_camera(i).translation;
  const Rigid3 camera_from_world = world_from_camera(i).inverse();
  SimulatedFeatures out;
  FeatureFrame& frame = out.frame;
  frame.time_us = time_us(i);
  frame.publisher = 1 + options_.seed;
  frame.seq = i;
  frame.camera = "cam0";
  frame.calibration_id = camera_.id();
  frame.width = camera_.width;
  frame.height = camera_.height;
  constexpr double kNearest = 0.3, kSmallest = 1.2, kLargest = 30;  // m; px
  for (int k = 0; k < static_cast<int>(points_.size()); ++k) {
    if (static_cast<int>(out.point.size()) == options_.max_features) break;
    const Vector3d x = camera_from_world * points_[k];
    if (x.z() < kNearest || x.z() > kSight) continue;
    const double scale = camera_.fx * size_[k] / x.z();
    if (scale < kSmallest || scale > kLargest) continue;
    const Eigen::Vector2d pixel = camera_.pixel_from_normalized(x.hnormalized()) +
                                  options_.noise_px * random.normal_vector<2>() + drift(k, centre);
    if (random.uniform() >= options_.repeatability || pixel.minCoeff() < 0 ||
        pixel.x() > camera_.width - 1 || pixel.y() > camera_.height - 1)
      continue;
    frame.keypoints.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
                               static_cast<float>(options_.sigma_px), static_cast<float>(scale), 0,
                               response_of(k), static_cast<std::int8_t>(sign_of(k))});
    out.point.push_back(k);
  }
  for (const int k : looks_of(out.point, options_.wrong_share, random)) {
    const auto begin = descriptors_.begin() + static_cast<std::ptrdiff_t>(k) * kDescriptorSize;
    frame.descriptors.insert(frame.descriptors.end(), begin, begin + kDescriptorSize);
  }
  return out;
}

}  // namespace eifmap
