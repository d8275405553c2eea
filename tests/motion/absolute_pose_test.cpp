#include "motion/absolute_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <stdexcept>

#include "support/synthetic_scene.h"

namespace eifmap {
namespace {

using test::kRadiansPerPixel;
using test::map_view;
using test::Random;
using test::SceneOptions;

constexpr double kDegree = M_PI / 180;

Rigid3 random_pose(Random& random) {
  return {random.rotation(), 5 * random.normal_vector<3>()};
}

double nees(const AbsolutePose& pose, const Rigid3& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << so3_log(pose.world_from_camera.rotation.conjugate() * truth.rotation),
      truth.translation - pose.world_from_camera.translation;
  return error.dot(pose.covariance.llt().solve(error));
}

// Guesses up to ten degrees and a twelfth of the depth off, a third of the matches wrong.
TEST(AbsolutePose, ConvergesFromFarOff) {
  for (double far : {0.1, 0.5, 1.0})
    for (int seed = 1; seed <= 50; ++seed) {
      Random random(seed);
      const Rigid3 truth = random_pose(random);
      const auto observations = map_view(truth, {.number = 200, .outliers = 0.3}, seed);
      const Rigid3 guess =
          retract(truth, far * 10 * kDegree * random.unit_vector(), far * random.unit_vector());
      const AbsolutePose pose = refine_absolute_pose(guess, observations, {});
      ASSERT_TRUE(pose.ok()) << far << ' ' << seed;
      EXPECT_LT((pose.world_from_camera.translation - truth.translation).norm(), 0.05);
      EXPECT_LT(pose.world_from_camera.rotation.angularDistance(truth.rotation), 0.2 * kDegree);
      EXPECT_GT(pose.num_inliers, 120);
    }
}

TEST(AbsolutePose, CovarianceIsHonest) {
  constexpr int kSeeds = 200;
  for (double outliers : {0.0, 0.4}) {
    double sum = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      Random random(seed);
      const Rigid3 truth = random_pose(random);
      const auto observations = map_view(truth, {.number = 150, .outliers = outliers}, seed);
      const AbsolutePose pose = refine_absolute_pose(truth, observations, {});
      ASSERT_TRUE(pose.ok());
      sum += nees(pose, truth);
    }
    EXPECT_GT(sum / kSeeds, 4.5);  // target 6, standard error sqrt(12 / 200) = .24
    EXPECT_LT(sum / kSeeds, 7);
  }
}

TEST(AbsolutePose, RefusesTooFew) {
  const Rigid3 truth;
  EXPECT_EQ(refine_absolute_pose(truth, map_view(truth, {.number = 14}, 1), {}).reason,
            Reason::kTooFewInliers);
  EXPECT_EQ(refine_absolute_pose(truth, {}, {}).reason, Reason::kTooFewInliers);
  EXPECT_EQ(solve_pnp({}, kRadiansPerPixel, {}).reason, Reason::kTooFewInliers);
}

TEST(AbsolutePose, TakesWhatIsBehindForAnOutlier) {
  const Rigid3 truth;
  auto observations = map_view(truth, {.number = 100}, 1);
  observations[7].point = -observations[7].point;  // projects to the same place
  const AbsolutePose pose = refine_absolute_pose(truth, observations, {});
  ASSERT_TRUE(pose.ok());
  EXPECT_EQ(pose.inlier[7], 0);
  EXPECT_LT(pose.world_from_camera.translation.norm(), 0.05);
}

TEST(Pnp, FindsThePoseWithoutAGuess) {
  for (double outliers : {0.0, 0.5, 0.6})
    for (int seed = 1; seed <= 50; ++seed) {
      Random random(seed);
      const Rigid3 truth = random_pose(random);
      const auto observations = map_view(truth, {.number = 200, .outliers = outliers}, seed);
      const AbsolutePose pose = solve_pnp(observations, kRadiansPerPixel, {});
      ASSERT_TRUE(pose.ok()) << outliers << ' ' << seed;
      EXPECT_LT((pose.world_from_camera.translation - truth.translation).norm(), 0.05);
      EXPECT_LT(pose.world_from_camera.rotation.angularDistance(truth.rotation), 0.2 * kDegree);
    }
}

TEST(Pnp, RefusesOutliersAlone) {
  Random random(1);
  for (int seed = 1; seed <= 20; ++seed)
    EXPECT_FALSE(solve_pnp(map_view(random_pose(random), {.number = 100, .outliers = 1}, seed),
                           kRadiansPerPixel, {})
                     .ok());
}

// All on one line: three points of it fix no pose, and nothing may break.
TEST(Pnp, SurvivesPointsOnALine) {
  std::vector<MapObservation> line;
  for (int k = 0; k < 40; ++k) line.push_back({{0.1 * k, 0, 5}, {0.02 * k, 0}, 0.001});
  const AbsolutePose pose = solve_pnp(line, kRadiansPerPixel, {});
  EXPECT_TRUE(pose.world_from_camera.translation.allFinite());
}

TEST(Pnp, IsTheSameEveryTime) {
  const auto observations = map_view({}, {.number = 120, .outliers = 0.5}, 3);
  const AbsolutePose first = solve_pnp(observations, kRadiansPerPixel, {});
  AbsolutePoseOptions other_seed;
  other_seed.seed = 99;
  solve_pnp(observations, kRadiansPerPixel, other_seed);
  const AbsolutePose again = solve_pnp(observations, kRadiansPerPixel, {});
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first.world_from_camera.translation, again.world_from_camera.translation);
  EXPECT_EQ(first.covariance, again.covariance);
  EXPECT_EQ(first.inlier, again.inlier);
}

TEST(AbsolutePose, ThrowsOnMisuse) {
  AbsolutePoseOptions options;
  options.min_inliers = 3;
  EXPECT_NE(options.problem().find("min_inliers"), std::string::npos);
  EXPECT_THROW(refine_absolute_pose({}, {}, options), std::invalid_argument);
  EXPECT_THROW(solve_pnp({}, 0, {}), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
