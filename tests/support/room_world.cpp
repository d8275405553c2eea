#include "support/room_world.h"

#include <algorithm>
#include <cmath>

#include "simulation/feature_world.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

using Eigen::Vector3d;

constexpr double kHalf = 4, kHeight = 3, kDoor = 1;  // m, of a room; half of the passage's width
constexpr double kRadius = 1.2;                      // m, that one walks around a room's middle
constexpr double kPerSquareMetre = 24;

// Whether the line between them passes the doors' planes within the doors.
bool sees(const Vector3d& from, const Vector3d& to, double plane) {
  if ((from.x() < plane) == (to.x() < plane)) return true;
  const double share = (plane - from.x()) / (to.x() - from.x());
  return std::abs(from.z() + share * (to.z() - from.z())) < kDoor;
}

std::vector<std::int8_t> descriptor_of(int looks) {
  Random random(static_cast<std::uint64_t>(looks) + 77);
  const Eigen::Matrix<double, kDescriptorSize, 1> d =
      254 * random.normal_vector<kDescriptorSize>().normalized();
  std::vector<std::int8_t> descriptor;
  for (const double x : d)
    descriptor.push_back(static_cast<std::int8_t>(std::lround(std::clamp(x, -127.0, 127.0))));
  return descriptor;
}

}  // namespace

RoomWorld::RoomWorld(const RoomWorldOptions& options)
    : options_(options), camera_(feature_world_camera()) {
  for (const double x : {0.0, kApart}) {
    add_wall({x - kHalf, 0, kHalf}, {2 * kHalf, 0, 0}, {0, 0, -1});
    add_wall({x - kHalf, 0, -kHalf}, {2 * kHalf, 0, 0}, {0, 0, 1});
    add_wall({x - kHalf, 0, -kHalf}, {0, 0, 2 * kHalf}, {1, 0, 0});
    add_wall({x + kHalf, 0, -kHalf}, {0, 0, 2 * kHalf}, {-1, 0, 0});
  }
  const double length = kApart - 2 * kHalf;
  add_wall({kHalf, 0, kDoor}, {length, 0, 0}, {0, 0, -1});
  add_wall({kHalf, 0, -kDoor}, {length, 0, 0}, {0, 0, 1});
  const auto in_door = [](const Point& p) {
    return p.faces.x() != 0 && std::abs(p.place.z()) < kDoor && p.place.x() > 0 &&
           p.place.x() < kApart;
  };
  std::erase_if(points_, in_door);
  repeat_walls();
}

// A wall stands out by up to half a metre.
void RoomWorld::add_wall(const Vector3d& corner, const Vector3d& along, const Vector3d& faces) {
  Random random(static_cast<std::uint64_t>(options_.seed) * 1'009 + points_.size());
  const auto number = static_cast<int>(kPerSquareMetre * along.norm() * kHeight);
  const double relief = along.norm() > kHalf + 3 ? 0.5 : 0.1;  // the passage is narrow
  for (int i = 0; i < number; ++i) {
    Point point;
    point.place = corner + random.uniform() * along + random.uniform(0, relief) * faces;
    point.place.y() = random.uniform(-kHeight / 2, kHeight / 2);
    point.faces = faces;
    point.size = 0.01 * std::exp(random.uniform(0, 3));
    point.looks = options_.seed * 100'000 + static_cast<int>(points_.size());
    points_.push_back(point);
  }
}

// The wall of A that faces the other way than its door does, in the middle, again in B.
void RoomWorld::repeat_walls() {
  const auto is_alike = [this](const Point& p, double x) {
    return p.faces.z() == -1 && std::abs(p.place.x() - x) < options_.alike * kHalf &&
           p.place.z() > kDoor;
  };
  std::erase_if(points_, [&](const Point& p) { return is_alike(p, kApart); });
  std::vector<Point> again;
  for (const Point& p : points_)
    if (is_alike(p, 0)) again.push_back(p);
  for (Point& p : again) {
    p.place.x() += kApart;
    points_.push_back(p);
  }
}

Rigid3 RoomWorld::in_room(bool b, double angle) {
  const Vector3d out(std::cos(angle), 0, -std::sin(angle));
  // At angle 0 the camera looks along x: z of the camera is that, its x is -z of the world.
  const Eigen::Quaterniond turn = (so3_exp({0, angle, 0}) * so3_exp({0, M_PI / 2, 0})).normalized();
  return {turn, (b ? centre_of_b() : Vector3d::Zero()) + kRadius * out};
}

Rigid3 RoomWorld::on_the_way(double share, bool looks_back) {
  Rigid3 pose = in_room(false, looks_back ? M_PI : 0);
  pose.translation.x() += share * kApart;
  pose.translation.z() += 0.15 * std::sin(12 * share);
  pose.translation.y() += 0.05 * std::sin(31 * share);
  return pose;
}

FeatureFrame RoomWorld::frame(const Rigid3& world_from_camera, int number) const {
  constexpr double kNearest = 0.3, kFarthest = 15, kSmallest = 1.2, kLargest = 30;  // m; px
  Random random(static_cast<std::uint64_t>(options_.seed) * 1'000'003 +
                static_cast<std::uint64_t>(number) + 1);
  const Rigid3 camera_from_world = world_from_camera.inverse();
  const Vector3d& centre = world_from_camera.translation;
  FeatureFrame frame;
  frame.publisher = 1;
  frame.seq = number;
  frame.camera = "cam0";
  frame.calibration_id = camera_.id();
  frame.width = camera_.width;
  frame.height = camera_.height;
  std::vector<int> looks;
  for (const Point& point : points_) {
    const Vector3d x = camera_from_world * point.place;
    if (x.z() < kNearest || x.norm() > kFarthest || (centre - point.place).dot(point.faces) <= 0)
      continue;
    if (!sees(centre, point.place, kHalf) || !sees(centre, point.place, kApart - kHalf)) continue;
    const double scale = camera_.fx * point.size / x.z();
    if (scale < kSmallest || scale > kLargest) continue;
    const Eigen::Vector2d pixel = camera_.pixel_from_normalized(x.hnormalized()) +
                                  options_.noise_px * random.normal_vector<2>();
    if (random.uniform() >= options_.repeatability || pixel.minCoeff() < 0 ||
        pixel.x() > camera_.width - 1 || pixel.y() > camera_.height - 1)
      continue;
    frame.keypoints.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
                               static_cast<float>(options_.noise_px / 2), static_cast<float>(scale),
                               0, 1.0F / static_cast<float>(1 + looks.size()),
                               static_cast<std::int8_t>(point.looks % 2 == 0 ? 1 : -1)});
    looks.push_back(point.looks);
  }
  for (std::size_t k = 0; k + 2 < looks.size(); ++k)
    if (random.uniform() < options_.wrong_share && looks[k] % 2 == looks[k + 2] % 2)
      std::swap(looks[k], looks[k + 2]);
  for (const int l : looks) {
    const std::vector<std::int8_t> descriptor = descriptor_of(l);
    frame.descriptors.insert(frame.descriptors.end(), descriptor.begin(), descriptor.end());
  }
  return frame;
}

}  // namespace eifmap::test
