#include "consistency/trajectory_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "options.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

constexpr double kCell = 15;  // m

std::vector<Rigid3> read_poses(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<Rigid3> poses;
  std::array<double, 12> m{};
  while (in >> m[0]) {
    for (std::size_t k = 1; k < 12; ++k) in >> m[k];
    Eigen::Matrix3d rotation;
    rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    poses.push_back({Eigen::Quaterniond(rotation).normalized(), {m[3], m[7], m[11]}});
  }
  if (poses.size() < 2) throw std::runtime_error(file.string() + ": no trajectory");
  return poses;
}

// 0.7 m a frame, swaying a little.
std::vector<Rigid3> straight_poses(int frames) {
  std::vector<Rigid3> poses;
  for (int k = 0; k < frames; ++k)
    poses.push_back({so3_exp({0.005 * std::sin(0.13 * k), 0.01 * std::sin(0.07 * k), 0}),
                     {0.2 * std::sin(0.05 * k), 0.03 * std::sin(0.21 * k), 0.7 * k}});
  return poses;
}

// A descriptor of the point's own.
void append_descriptor(int point, std::uint64_t seed, std::vector<std::int8_t>& descriptors) {
  Random random(seed * 7919 + static_cast<std::uint64_t>(point));
  const Eigen::Matrix<double, kDescriptorSize, 1> looks =
      254 * random.normal_vector<kDescriptorSize>().normalized();
  for (const double x : looks)
    descriptors.push_back(static_cast<std::int8_t>(std::lround(std::clamp(x, -127.0, 127.0))));
}

}  // namespace

TrajectoryWorld::TrajectoryWorld(const std::filesystem::path& file,
                                 const TrajectoryWorldOptions& options)
    : TrajectoryWorld(read_poses(file), options) {}

TrajectoryWorld::TrajectoryWorld(const TrajectoryWorldOptions& options)
    : TrajectoryWorld(straight_poses(options.max_frames), options) {}

TrajectoryWorld::TrajectoryWorld(std::vector<Rigid3> poses, const TrajectoryWorldOptions& options)
    : options_(options),
      camera_{1241, 376, CameraModel::kPinhole, 718.9, 718.9, 607.2, 185.2, {}},
      poses_(std::move(poses)) {
  if (options.max_frames > 0 && size() > options.max_frames)
    poses_.resize(static_cast<std::size_t>(options.max_frames));
  if (options.period > 0) {
    make_periods();
    return;
  }
  // What lies ahead of the last pose as well.
  constexpr double kBehind = 6, kAlike = 0.7;   // m; cosine
  std::vector<std::pair<Rigid3, double>> made;  // from where, and how far along the way
  double along = 0, since = 0;
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    if (k > 0) {
      const double step = (poses_[k].translation - poses_[k - 1].translation).norm();
      along += step, since += step;
    }
    if (k > 0 && since < 1) continue;
    const Eigen::Vector3d ahead = poses_[k].matrix().col(2);
    const bool is_old = std::any_of(made.begin(), made.end(), [&](const auto& m) {
      return along - m.second > 30 &&
             (m.first.translation - poses_[k].translation).norm() < kBehind &&
             m.first.matrix().col(2).dot(ahead) > kAlike;
    });
    if (!is_old) make_points(poses_[k], k == 0 ? 30 : since);
    made.emplace_back(poses_[k], along);
    since = 0;
  }
  make_points(poses_.back(), 30);
}

std::pair<int, int> TrajectoryWorld::cell(const Eigen::Vector3d& place) const {
  return {static_cast<int>(std::floor(place.x() / kCell)),
          static_cast<int>(std::floor(place.z() / kCell))};
}

void TrajectoryWorld::make_points(const Rigid3& pose, double length) {
  Random random(static_cast<std::uint64_t>(options_.seed) * 1'000'003 + points_.size());
  const int count = static_cast<int>(options_.points_per_m * length);
  for (int k = 0; k < count; ++k) {
    const double side = random.uniform() < 0.5 ? -1 : 1;
    const double ahead = 8 + random.uniform(0, length);
    const double which = random.uniform();
    Point point;
    if (which < 0.65)  // walls and what stands before them
      point.place =
          pose * Eigen::Vector3d(side * random.uniform(4, 14), random.uniform(-6, 1.6), ahead);
    else if (which < 0.85)  // behind them
      point.place = pose * Eigen::Vector3d(side * random.uniform(14, 35), random.uniform(-12, 0),
                                           ahead + random.uniform(0, 20));
    else  // the road
      point.place = pose * Eigen::Vector3d(random.uniform(-4, 4), 1.65, ahead);
    point.faces = pose.matrix().col(2);
    point.size = 0.03 * std::exp(random.uniform(0, 3));
    point.looks = num_points();
    points_of_cell_[cell(point.place)].push_back(num_points());
    points_.push_back(point);
  }
}

void TrajectoryWorld::make_periods() {
  make_points(Rigid3(), options_.period);
  const std::vector<Point> first = points_;
  for (double from = options_.period; from < poses_.back().translation.z() + options_.range;
       from += options_.period)
    for (Point point : first) {
      point.place.z() += from;
      points_of_cell_[cell(point.place)].push_back(num_points());
      points_.push_back(point);
    }
}

FeatureFrame TrajectoryWorld::frame(int i) const {
  constexpr double kNearest = 2, kSmallest = 1.2, kLargest = 30, kFaces = 0.34;  // m; px; cosine
  Random random(static_cast<std::uint64_t>(options_.seed) * 5'000'011 +
                static_cast<std::uint64_t>(i));
  const Rigid3& pose = poses_[static_cast<std::size_t>(i)];
  const Rigid3 camera_from_world = pose.inverse();
  const auto [column, row] = cell(pose.translation);
  const int reach = static_cast<int>(std::ceil(options_.range / kCell));
  std::vector<int> near;
  for (int c = column - reach; c <= column + reach; ++c)
    for (int r = row - reach; r <= row + reach; ++r)
      if (const auto of_cell = points_of_cell_.find({c, r}); of_cell != points_of_cell_.end())
        near.insert(near.end(), of_cell->second.begin(), of_cell->second.end());
  std::sort(near.begin(), near.end());
  FeatureFrame frame;
  frame.time_us = time_us(i);
  frame.publisher = 1 + options_.seed;
  frame.seq = i;
  frame.camera = "cam0";
  frame.calibration_id = camera_.id();
  frame.width = camera_.width;
  frame.height = camera_.height;
  const double sigma_px = options_.noise_px / options_.noise_ratio / MapperOptions().sigma_factor;
  std::vector<int> seen;
  for (const int k : near) {
    const Point& point = points_[static_cast<std::size_t>(k)];
    const Eigen::Vector3d x = camera_from_world * point.place;
    if (x.z() < kNearest || x.norm() > options_.range) continue;
    if ((point.place - pose.translation).normalized().dot(point.faces) < kFaces) continue;
    const double scale = camera_.fx * point.size / x.z();
    if (scale < kSmallest || scale > kLargest) continue;
    const Eigen::Vector2d pixel = camera_.pixel_from_normalized(x.hnormalized()) +
                                  options_.noise_px * random.normal_vector<2>();
    if (random.uniform() >= options_.repeatability || pixel.minCoeff() < 0 ||
        pixel.x() > camera_.width - 1 || pixel.y() > camera_.height - 1)
      continue;
    frame.keypoints.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
                               static_cast<float>(sigma_px), static_cast<float>(scale), 0,
                               1 / static_cast<float>(seen.size() + 1),
                               static_cast<std::int8_t>(point.looks % 2 == 0 ? 1 : -1)});
    seen.push_back(point.looks);
  }
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const bool wrong = random.uniform() < options_.wrong_share;
    append_descriptor(wrong ? num_points() + seen[k] * 31 + i : seen[k],
                      static_cast<std::uint64_t>(options_.seed), frame.descriptors);
  }
  return frame;
}

}  // namespace eifmap::test
