#include "sequence/consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "support/random.h"

namespace eifmap::test {
namespace {

Rigid3 random_pose(Random& random) {
  return {random.rotation(), 5 * random.normal_vector<3>()};
}

// A map that is the truth in another frame and unit, but for keyframe 1, which lies across the
// baseline's direction from where it should: the scale is that along the direction.
TEST(TruthInMap, BringsTheTruthIntoTheGauge) {
  Random random(3);
  const Rigid3 map_from_world = random_pose(random);
  constexpr double kScale = 3.7;
  const auto in_map = [&](const Rigid3& pose) {
    Rigid3 moved = map_from_world * pose;
    moved.translation *= kScale;
    return moved;
  };
  const Rigid3 first = map_from_world.inverse(), second = random_pose(random);
  const Eigen::Vector3d centre = in_map(second).translation;
  const Eigen::Vector3d across = 1e-3 * centre.unitOrthogonal() * centre.norm();
  const TruthInMap exact(first, second, centre), off(first, second, centre + across);
  EXPECT_NEAR(exact.scale(), kScale, 1e-9);
  EXPECT_NEAR(off.scale(), kScale, 2e-6 * kScale);
  for (int k = 0; k < 10; ++k) {
    const Rigid3 pose = random_pose(random);
    EXPECT_LT(pose_error(exact(pose), in_map(pose)).norm(), 1e-9);
  }
}

TEST(PoseError, IsWhatTheEstimateLacks) {
  Random random(4);
  for (int k = 0; k < 10; ++k) {
    const Rigid3 estimate = random_pose(random);
    const Eigen::Vector3d w = 0.3 * random.normal_vector<3>(), dc = random.normal_vector<3>();
    PoseVector expected;
    expected << dc, w;
    EXPECT_LT((pose_error(estimate, retract(estimate, w, dc)) - expected).norm(), 1e-12);
  }
}

TEST(Nees, IsSixOnAverageWhereTheCovarianceIsRight) {
  Random random(5);
  PoseMatrix root = PoseMatrix::Zero();
  for (int c = 0; c < 6; ++c) root.col(c) = random.normal_vector<6>();
  const PoseMatrix covariance = root * root.transpose();
  double sum = 0;
  constexpr int kDraws = 3000;
  for (int k = 0; k < kDraws; ++k) sum += nees(root * random.normal_vector<6>(), covariance);
  EXPECT_NEAR(sum / kDraws, 6, 4 * std::sqrt(12.0 / kDraws));
  EXPECT_TRUE(std::isinf(nees(PoseVector::Ones(), PoseMatrix::Zero())));
}

}  // namespace
}  // namespace eifmap::test
