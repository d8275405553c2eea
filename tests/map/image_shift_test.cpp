#include "map/image_shift.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/map_scene.h"

namespace eifmap::test {
namespace {

struct Scene {
  Scene() : map(scene_with_landmarks(SyntheticStream(), 5)) {
    map.update();
    for (int t = 0; t < map.num_tracks(); ++t)
      if (map.track(t).is_landmark()) sights.push_back({t, 0});
  }
  Map map;
  std::vector<LandmarkSight> sights;
};

TEST(ImageShift, OfATurnIsItsAngleAndHasItsDirection) {
  const Scene scene;
  ASSERT_FALSE(scene.sights.empty());
  const Rigid3& from = scene.map.pose(4);
  EXPECT_EQ(median_step(scene.map, scene.sights, from, from).norm(), 0);
  EXPECT_EQ(median_shift(scene.map, scene.sights, from, from), 0);
  constexpr double kAngle = 0.02;
  const Rigid3 turned(
      from.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(kAngle, Eigen::Vector3d::UnitY())),
      from.translation);
  const Eigen::Vector2d step = median_step(scene.map, scene.sights, from, turned);
  EXPECT_NEAR(step.x(), -kAngle, 0.2 * kAngle);  // what is in front moves to the left
  EXPECT_NEAR(step.y(), 0, 0.1 * kAngle);
  EXPECT_NEAR(median_shift(scene.map, scene.sights, from, turned), kAngle, 0.2 * kAngle);
}

// One says how what both see moves; the other must not take a turn away for a small one.
TEST(ImageShift, OfWhatIsBehindIsNoneAndInfinite) {
  const Scene scene;
  const Rigid3& from = scene.map.pose(4);
  const Rigid3 away(
      from.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY())),
      from.translation);
  EXPECT_EQ(median_step(scene.map, scene.sights, from, away).norm(), 0);
  EXPECT_TRUE(std::isinf(median_shift(scene.map, scene.sights, from, away)));
}

}  // namespace
}  // namespace eifmap::test
