#include "support/long_way.h"

#include <cmath>
#include <numbers>

namespace eifmap::test {
namespace {

constexpr std::size_t kSightsToEnter = 3;

bool sees(const Rigid3& pose, const Eigen::Vector3d& point, const LongWayOptions& o,
          Eigen::Vector2d& x) {
  return (point - pose.translation).squaredNorm() < o.range * o.range && project(pose, point, x) &&
         std::abs(x.x()) < o.field && std::abs(x.y()) < 0.5 * o.field;
}

}  // namespace

std::size_t LongWay::num_sights() const {
  std::size_t n = 0;
  for (const auto& of_pose : sights) n += of_pose.size();
  return n;
}

std::vector<Rigid3> round_course(int num_poses, int poses_a_lap, double step) {
  const double radius = step * poses_a_lap / (2 * std::numbers::pi);
  std::vector<Rigid3> poses;
  for (int p = 0; p < num_poses; ++p) {
    const double angle = 2 * std::numbers::pi * p / poses_a_lap;
    // Later laps keep to a lane of their own, half a metre further out.
    const double r = radius + 0.5 * (p / poses_a_lap);
    // x to the right, y down, z ahead: at angle 0 along the world's z.
    poses.push_back({so3_exp(Eigen::Vector3d(0, -angle, 0)),
                     Eigen::Vector3d(-radius + r * std::cos(angle), 0, r * std::sin(angle))});
  }
  return poses;
}

LongWay make_long_way(std::vector<Rigid3> poses, const LongWayOptions& o) {
  LongWay world{o, std::move(poses), {}, {}};
  world.sights.resize(world.poses.size());
  Random random(o.seed);
  const int num_points = static_cast<int>(o.points_per_pose * world.poses.size());
  for (int k = 0; k < num_points; ++k) {
    const Rigid3& pose = world.poses[static_cast<std::size_t>(k / o.points_per_pose)];
    const double z = random.uniform(o.nearest, o.farthest);
    world.points.push_back(pose * Eigen::Vector3d(z * random.uniform(-o.field, o.field),
                                                  z * random.uniform(-o.field, o.field) / 2, z));
    for (std::size_t p = 0; p < world.poses.size(); ++p) {
      Eigen::Vector2d x;
      if (!sees(world.poses[p], world.points.back(), o, x)) continue;
      x += o.noise_px * o.pixel * random.normal_vector<2>();
      world.sights[p].push_back({k, x});
    }
  }
  return world;
}

LongWayFeed::LongWayFeed(const LongWay& world, const FilterOptions& options)
    : world_(world),
      filter_(options, world.options.pixel),
      random_(world.options.seed + 1),
      points_(world.points.size()) {}

void LongWayFeed::enter(Point& point, int index) {
  // Where a triangulation would put it, or so; the filter moves it.
  const Rigid3& from = filter_.pose(point.sights.front().first);
  const Eigen::Vector3d in_camera =
      world_.poses[point.sights.front().first].inverse() * world_.points[index];
  const double off = 1 + 0.02 * random_.normal();
  point.landmark = filter_.add_landmark(from * (off * in_camera), Eigen::Matrix3d::Zero());
  for (const auto& [pose, x] : point.sights)
    filter_.add_measurement(point.landmark, pose, x,
                            world_.options.noise_px * world_.options.pixel);
  point.sights = {};
}

void LongWayFeed::add_next() {
  const int p = num_poses();
  if (p == 0) {
    filter_.add_pose(world_.poses[0]);
  } else {
    const Rigid3 motion = world_.poses[p - 1].inverse() * world_.poses[p];
    // The first baseline is the gauge: both of its ends are true.
    const double off = p == 1 ? 0 : 1;
    filter_.add_pose(retract(filter_.pose(p - 1) * motion, off * 0.002 * random_.normal_vector<3>(),
                             off * 0.01 * random_.normal_vector<3>()));
  }
  for (const PointSight& sight : world_.sights[p]) {
    Point& point = points_[sight.point];
    if (point.landmark >= 0) {
      filter_.add_measurement(point.landmark, p, sight.x,
                              world_.options.noise_px * world_.options.pixel);
      continue;
    }
    point.sights.emplace_back(p, sight.x);
    if (point.sights.size() == kSightsToEnter) enter(point, sight.point);
  }
}

}  // namespace eifmap::test
