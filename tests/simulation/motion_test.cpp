#include "simulation/motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace eifmap::simulation {
namespace {

Rigid3 step(const Motion& motion, double from, double to) {
  return motion(from).inverse() * motion(to);
}

double angle_deg(const Rigid3& motion) {
  return so3_log(motion.rotation).norm() * 180 / M_PI;
}

constexpr double kAngle = 100 * M_PI / 180;

TEST(Motion, PanningIsARotationAlone) {
  const Motion motion = panning(Rigid3(so3_exp({0.1, 1, 0}), {1, -1.6, 2}), kAngle, 8);
  for (double t = 0; t < 10; t += 0.5) EXPECT_EQ(motion(t).translation, motion(0).translation);
  EXPECT_NEAR(angle_deg(step(motion, 0, 4)), 100, 1e-6);
  EXPECT_NEAR(angle_deg(step(motion, 0, 8)), 0, 1e-6);
}

TEST(Motion, APauseInterruptsAWalk) {
  const Motion walk = walking({}), paused = with_pause(walk, 5, 20);
  EXPECT_EQ(step(paused, 0, 3).translation, step(walk, 0, 3).translation);
  EXPECT_EQ(step(paused, 5, 24.9).translation.norm(), 0);
  EXPECT_EQ(angle_deg(step(paused, 5, 24.9)), 0);
  EXPECT_EQ(paused(30).translation, walk(10).translation);
}

TEST(Motion, LookingAroundTurnsOnTheSpotAndBack) {
  const Motion walk = walking({}), motion = with_look_around(walk, 5, 8, kAngle);
  EXPECT_EQ(step(motion, 5, 9).translation.norm(), 0);
  EXPECT_NEAR(angle_deg(step(motion, 5, 9)), 100, 1e-6);
  EXPECT_NEAR(angle_deg(step(motion, 5, 13)), 0, 1e-6);
  EXPECT_EQ(motion(16).translation, walk(8).translation);
  EXPECT_NEAR(motion(16).rotation.angularDistance(walk(8).rotation), 0, 1e-12);
}

TEST(Motion, DrivingGoesAheadAndSidewaysToTheRight) {
  const Rigid3 start(so3_exp({0, M_PI / 2, 0}), {3, -1.5, 0});  // east
  const Motion drive = driving(start, 20), sideways = moving_sideways(start, 0.5);
  EXPECT_NEAR(drive(2).translation.x() - drive(0).translation.x(), 40, 0.1);
  EXPECT_LT(angle_deg(step(drive, 0, 2)), 3);
  EXPECT_NEAR(sideways(4).translation.z() - sideways(0).translation.z(), -2, 0.1);  // south
  EXPECT_LT(angle_deg(step(sideways, 0, 4)), 20);
}

}  // namespace
}  // namespace eifmap::simulation
