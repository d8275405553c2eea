#include "simulation/walk.h"

#include <gtest/gtest.h>

#include <algorithm>

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

}  // namespace
}  // namespace eifmap::simulation
