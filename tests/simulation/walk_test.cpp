#include "simulation/walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace eifmap::simulation {
namespace {

TEST(Walk, ComesBackAfterALap) {
  const Walk walk;
  const double lap = walk.lap_length() / walk.speed;
  EXPECT_GT(walk.lap_length(), 38);
  EXPECT_LT(walk.lap_length(), 60);
  const Rigid3 first = walk.world_from_camera(0), again = walk.world_from_camera(lap);
  EXPECT_LT((first.translation - again.translation).norm(), 0.4);
  EXPECT_LT(first.rotation.angularDistance(again.rotation), 0.4);
}

TEST(Walk, IsSmoothAndAsFastAsItSays) {
  const Walk walk;
  double path = 0;
  for (double t = 0; t < 20; t += 0.05) {
    const Rigid3 a = walk.world_from_camera(t), b = walk.world_from_camera(t + 0.05);
    const double step = (b.translation - a.translation).norm();
    path += step;
    EXPECT_GT(step, 0.07) << t;
    EXPECT_LT(step, 0.15) << t;
    EXPECT_LT(a.rotation.angularDistance(b.rotation), 0.06) << t;  // 3.4 deg
  }
  EXPECT_NEAR(path, 20 * walk.speed, 0.05 * path);
}

TEST(Walk, LooksAheadAndInwardsAtEyeHeight) {
  const Walk walk;
  for (double t = 0; t < 20; t += 0.5) {
    const Rigid3 pose = walk.world_from_camera(t);
    const Eigen::Vector3d velocity =
        (walk.world_from_camera(t + 0.01).translation - pose.translation).normalized();
    const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitZ();
    EXPECT_GT(ahead.dot(velocity), 0.85) << t;
    EXPECT_NEAR(-pose.translation.y(), walk.eye_height, 0.1);
    const Eigen::Vector3d down = pose.rotation * Eigen::Vector3d::UnitY();
    EXPECT_GT(down.y(), 0.99);
  }
}

double heading_of(const Rigid3& pose) {
  const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitZ();
  return std::atan2(ahead.x(), ahead.z());
}

// Straight on, a quarter turn to the left in half a second, straight on; never a jump.
TEST(Walk, TurnsFastAtTheCorners) {
  Walk walk;
  walk.path = Path::kRectangle;
  const auto [begin, end] = first_turn(walk);
  EXPECT_NEAR(end - begin, 0.5, 1e-9);
  const auto centre = [&walk](double t) { return walk.world_from_camera(t).translation; };
  EXPECT_GT((centre(begin) - centre(0)).normalized().x(), 0.99);      // east
  EXPECT_GT((centre(end + 3) - centre(end)).normalized().z(), 0.99);  // north
  const double before = heading_of(walk.world_from_camera(begin));
  const double after = heading_of(walk.world_from_camera(end));
  EXPECT_NEAR(before - after, M_PI / 2, 0.15);  // of which the hand's wandering
  const double lap = walk.lap_length() / walk.speed;
  for (double t = 0; t < lap + 1; t += 0.05) {
    const double step = (centre(t + 0.05) - centre(t)).norm();
    EXPECT_GT(step, 0.07) << t;
    EXPECT_LT(step, 0.15) << t;
  }
  EXPECT_LT((centre(lap) - centre(0)).norm(), 0.4);
}

TEST(Walk, LeadsStraightOn) {
  Walk walk;
  walk.path = Path::kStraight;
  walk.inwards = 0;
  const Rigid3 begin = walk.world_from_camera(0), end = walk.world_from_camera(10);
  EXPECT_NEAR(end.translation.z() - begin.translation.z(), 10 * walk.speed, 0.2);
  EXPECT_LT(std::abs(end.translation.x() - begin.translation.x()), 0.3);
  for (double t = 0; t < 10; t += 0.5)
    EXPECT_LT(std::abs(heading_of(walk.world_from_camera(t))), 0.2) << t;  // north
}

TEST(Walk, RollsAsFarAsAskedAndGoesTheSameWay) {
  Walk level, rolled;
  rolled.roll = 0.5;
  double most = 0;
  for (double t = 0; t < 20; t += 0.25) {
    const Rigid3 a = level.world_from_camera(t), b = rolled.world_from_camera(t);
    EXPECT_EQ(a.translation, b.translation);
    const Eigen::Vector3d w = so3_log(a.rotation.conjugate() * b.rotation);
    EXPECT_NEAR(w.head<2>().norm(), 0, 1e-12);  // about the optical axis alone
    most = std::max(most, std::abs(w.z()));
  }
  EXPECT_NEAR(most, 0.5, 0.01);
}

}  // namespace
}  // namespace eifmap::simulation
