#include "map/planar_start.h"

#include <gtest/gtest.h>

#include "support/synthetic_scene.h"

namespace eifmap::test {
namespace {

// A slanted wall full of points, all of them seen in every view.
class Wall {
 public:
  explicit Wall(std::uint64_t seed) : random_(seed) {
    SceneOptions options;
    options.plane = true;
    options.near = 4, options.far = 8;
    for (int k = 0; k < 150; ++k) points_.push_back(random_point(options, random_));
  }

  ObservedFrame view(const Rigid3& pose, std::int64_t time_us) {
    constexpr double kNoise = 0.3 * kRadiansPerPixel;
    ObservedFrame frame;
    frame.frame.time_us = time_us;
    for (const Eigen::Vector3d& point : points_) {
      frame.x.push_back((pose.inverse() * point).hnormalized() +
                        kNoise * random_.normal_vector<2>());
      frame.sigma.push_back(kNoise);
    }
    return frame;
  }

 private:
  Random random_;
  std::vector<Eigen::Vector3d> points_;
};

// Along the wall in an arc, turning a little: frame k at 10 a second.
Rigid3 pose_at(int k) {
  const double s = 0.08 * k, turn = 0.01 * k;
  return Rigid3(Eigen::Quaterniond(Eigen::AngleAxisd(-turn, Eigen::Vector3d::UnitY())),
                {s, 0.1 * std::sin(s), 0.15 * s * s});
}

FramePair pair_of(const ObservedFrame& i, const ObservedFrame& j) {
  FramePair pair;
  std::vector<Correspondence> all;
  for (int k = 0; k < i.size(); ++k) {
    pair.m.push_back({k, k});
    all.push_back(correspondence(i, j, pair.m.back()));
  }
  pair.relative = estimate_relative_pose(all, kRadiansPerPixel, {});
  return pair;
}

TEST(PlanarStart, AThirdViewLeavesTheTrueMotion) {
  int decided = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Wall wall(seed);
    PlanarStart start{MapperOptions()};
    const ObservedFrame anchor = wall.view(pose_at(0), 1);
    for (int k = 3; k < 40; ++k) {
      const ObservedFrame newest = wall.view(pose_at(k), 1 + k);
      FramePair pair = pair_of(anchor, newest);
      if (!pair.relative.ok()) continue;
      ASSERT_TRUE(pair.relative.planar);
      start.decide(anchor, newest, pair);
      if (pair.relative.planar) continue;
      ++decided;
      EXPECT_TRUE(pair.relative.alternatives.empty());
      EXPECT_GT(pair.relative.num_inliers, 140);
      const Eigen::Vector3d truth = pose_at(k).translation.normalized();
      EXPECT_GT(pair.relative.pose.direction.dot(truth), std::cos(2 * M_PI / 180))
          << "seed " << seed << " view " << k;
      EXPECT_LT(pair.relative.pose.i_from_j.angularDistance(pose_at(k).rotation), 0.01);
      break;
    }
  }
  EXPECT_GE(decided, 8);
}

TEST(PlanarStart, ViewsThatShowNothingNewLeaveItOpen) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Wall wall(seed);
    PlanarStart start{MapperOptions()};
    const ObservedFrame anchor = wall.view(pose_at(0), 1);
    for (int k = 0; k < 40; ++k) {
      const ObservedFrame newest = wall.view(pose_at(12), 2 + k);  // stands still
      FramePair pair = pair_of(anchor, newest);
      ASSERT_TRUE(pair.relative.ok());
      start.decide(anchor, newest, pair);
      EXPECT_TRUE(pair.relative.planar) << "seed " << seed << " view " << k;
    }
  }
}

// Another anchor: what was learnt of the one before says nothing.
TEST(PlanarStart, BeginsAnewWithAnotherAnchor) {
  Wall wall(3);
  PlanarStart start{MapperOptions()};
  for (int k = 10; k < 40; ++k) {
    const ObservedFrame anchor = wall.view(pose_at(0), k), newest = wall.view(pose_at(k), 100 + k);
    FramePair pair = pair_of(anchor, newest);
    ASSERT_TRUE(pair.relative.ok());
    start.decide(anchor, newest, pair);
    EXPECT_TRUE(pair.relative.planar);
  }
}

}  // namespace
}  // namespace eifmap::test
