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

// Ahead on the way, never a jump, and after a lap at the beginning.
TEST(Motion, DrivingRoundABlockLeadsBack) {
  constexpr double kSpeed = 5;
  const RoundedRectangle way{-10, 12, -8, 7, 6};
  const Motion drive = driving_round(way, 1.5, kSpeed);
  const double lap = way.lap_length() / kSpeed;
  EXPECT_NEAR(way.lap_length(), 2 * (10 + 3) + 2 * M_PI * 6, 1e-9);
  EXPECT_GT((drive(1).translation - drive(0).translation).normalized().x(), 0.99);  // east
  for (double t = 0; t < lap; t += 0.05) {
    const Rigid3 moved = step(drive, t, t + 0.05);
    EXPECT_NEAR(moved.translation.z(), 0.05 * kSpeed, 0.02) << t;
    EXPECT_LT(moved.translation.head<2>().norm(), 0.03) << t;
    EXPECT_LT(angle_deg(moved), 3) << t;
    EXPECT_NEAR(drive(t).translation.y(), -1.5, 0.02);
  }
  EXPECT_LT((drive(lap).translation - drive(0).translation).norm(), 0.25);
  EXPECT_GT((drive(lap / 2).translation - drive(0).translation).norm(), 10);
}

TEST(Motion, CarriedAwayItGoesOnFromElsewhere) {
  const Motion walk = walking({}), carried = with_carrying(walk, 6, 2, 1);
  EXPECT_EQ(carried(5.9).translation, walk(5.9).translation);
  EXPECT_EQ(carried(6).translation, walk(1).translation);
  EXPECT_EQ(carried(8).translation, walk(1).translation);
  EXPECT_EQ(carried(10).translation, walk(3).translation);
}

}  // namespace
}  // namespace eifmap::simulation
