#include <gtest/gtest.h>

#include "motion/epipolar_geometry.h"
#include "support/numeric_jacobian.h"
#include "support/synthetic_scene.h"

namespace eifmap {
namespace {

using test::numeric_jacobian;
using test::Random;
using test::relative_difference;
using test::SceneOptions;
using test::two_views;
using test::TwoViews;

RelativePose true_pose(const TwoViews& views) {
  RelativePose pose;
  pose.i_from_j = views.i_from_j.rotation;
  pose.direction = views.i_from_j.translation.normalized();
  return pose;
}

RelativePose moved(const RelativePose& pose, const Eigen::Matrix<double, 5, 1>& delta) {
  RelativePose result = pose;
  result.i_from_j = pose.i_from_j * so3_exp(delta.head<3>());
  result.direction = sphere_retract(pose.direction, delta.tail<2>());
  return result;
}

TEST(Sampson, IsZeroAtTheTruth) {
  SceneOptions options;
  options.noise_px = 0;
  const TwoViews views = two_views({so3_exp({0.1, -0.2, 0.3}), {1, 0.2, 0.5}}, options, 1);
  for (const Correspondence& match : views.matches)
    EXPECT_LT(std::abs(sampson_residual(match, true_pose(views))), 1e-9);
}

TEST(Sampson, IsWhite) {
  SceneOptions options;
  options.number = 4000;
  TwoViews views = two_views({so3_exp({0, 0.1, 0}), {1, 0, 0.3}}, options, 2);
  double sum = 0;
  for (const Correspondence& match : views.matches)
    sum += std::pow(sampson_residual(match, true_pose(views)), 2);
  EXPECT_NEAR(sum / options.number, 1, 0.08);  // standard error sqrt(2 / 4000) = .022
}

// Far from the solution and with unequal sigmas, so that every term of it matters.
TEST(Sampson, JacobianMatchesNumericOne) {
  Random random(3);
  for (int run = 0; run < 20; ++run) {
    TwoViews views =
        two_views({so3_exp(0.3 * random.normal_vector<3>()), 0.5 * random.unit_vector()},
                  {.number = 10}, 100 + run);
    RelativePose pose = true_pose(views);
    Eigen::Matrix<double, 5, 1> off = 0.2 * random.normal_vector<5>();
    pose = moved(pose, off);
    for (Correspondence& match : views.matches) {
      match.sigma_i *= random.uniform(0.3, 3);
      Eigen::Matrix<double, 1, 5> analytic;
      sampson_residual(match, pose, &analytic);
      const auto residual = [&](const Eigen::Matrix<double, 5, 1>& delta) {
        return Eigen::Matrix<double, 1, 1>(sampson_residual(match, moved(pose, delta)));
      };
      EXPECT_LT(relative_difference(analytic, numeric_jacobian<1, 5>(residual)), 1e-6);
    }
  }
}

TEST(Sampson, SaysNothingOfTheEpipoles) {
  RelativePose forward;
  Eigen::Matrix<double, 1, 5> jacobian;
  const Correspondence on_epipoles{{0, 0}, {0, 0}, 0.001, 0.001};
  EXPECT_EQ(sampson_residual(on_epipoles, forward, &jacobian), 0);
  EXPECT_EQ(jacobian.norm(), 0);
}

TEST(DepthSign, TellsFrontFromBehind) {
  const TwoViews views = two_views({so3_exp({0, 0.1, 0}), {1, 0, 0.2}}, {.noise_px = 0}, 4);
  const RelativePose pose = true_pose(views);
  RelativePose opposite = pose;
  opposite.direction = -pose.direction;
  for (const Correspondence& match : views.matches) {
    EXPECT_EQ(EpipolarGeometry(pose).depth_sign(match), DepthSign::kInFront);
    EXPECT_EQ(EpipolarGeometry(opposite).depth_sign(match), DepthSign::kBehind);
  }
}

TEST(DepthSign, LeavesDistantPointsUndecided) {
  const TwoViews views =
      two_views({so3_exp({0, 0.1, 0}), {1, 0, 0.2}}, {.near = 5000, .far = 9000}, 5);
  int decided = 0;
  for (const Correspondence& match : views.matches)
    decided += EpipolarGeometry(true_pose(views)).depth_sign(match) != DepthSign::kUndecided;
  EXPECT_LT(decided, 8);
}

// What it claims to be: the mean of J'J over noise, less J'J without noise.
TEST(JacobianNoise, IsTheExcessOfTheNoisyInformation) {
  Random random(6);
  const TwoViews exact =
      two_views({so3_exp({0, 0.05, 0}), {0.1, 0, 0.1}}, {.number = 20, .noise_px = 0}, 6);
  const RelativePose pose = true_pose(exact);
  const EpipolarGeometry geometry(pose);
  Eigen::Matrix2d clean = Eigen::Matrix2d::Zero(), noisy = clean, predicted = clean;
  Eigen::Matrix<double, 1, 5> j;
  constexpr int kDraws = 500;
  for (const Correspondence& match : exact.matches) {
    geometry.residual(match, &j);
    clean += j.tail<2>().transpose() * j.tail<2>();
    predicted += geometry.jacobian_noise(match);
    for (int draw = 0; draw < kDraws; ++draw) {
      Correspondence drawn = match;
      drawn.x_i += match.sigma_i * random.normal_vector<2>();
      drawn.x_j += match.sigma_j * random.normal_vector<2>();
      geometry.residual(drawn, &j);
      noisy += j.tail<2>().transpose() * j.tail<2>() / kDraws;
    }
  }
  EXPECT_LT((noisy - clean - predicted).norm(), 0.15 * predicted.norm());
  EXPECT_GT(predicted.norm(), 0.03 * clean.norm());  // and it is not nothing
}

}  // namespace
}  // namespace eifmap
