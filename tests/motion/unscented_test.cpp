// The Unscented transform of (R, T), and with it as the oracle, the linear covariance.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <ostream>

#include "motion/relative_pose.h"
#include "support/synthetic_scene.h"

namespace eifmap {
namespace {

using test::SceneOptions;
using test::two_views;
using test::TwoViews;
using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

const Eigen::Quaterniond kTurn = so3_exp({0.02, -0.05, 0.01});

struct Scene {
  const char* name;
  Eigen::Vector3d step;
  SceneOptions scene;
};

void PrintTo(const Scene& scene, std::ostream* out) {
  *out << scene.name;
}

RelativePose refine(const TwoViews& views, RelativePoseCovariance covariance) {
  RelativePose pose;
  pose.i_from_j = views.i_from_j.rotation * so3_exp({0.01, -0.01, 0.005});
  pose.direction = sphere_retract(views.i_from_j.translation.normalized(), {0.05, -0.05});
  std::vector<std::uint8_t> inlier;
  EXPECT_TRUE(refine_relative_pose(views.matches, pose, inlier, covariance));
  return pose;
}

// Variances of `a` in units of `b` along their common axes; all 1 where they are the same.
Vector5d ratios(const Matrix5d& a, const Matrix5d& b) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<Matrix5d>(a, b, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

class UnscentedOn : public testing::TestWithParam<Scene> {};

TEST_P(UnscentedOn, IsHonest) {
  constexpr int kSeeds = 120;
  double sum = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const TwoViews views = two_views({kTurn, GetParam().step}, GetParam().scene, seed);
    const RelativePose pose = refine(views, RelativePoseCovariance::kUnscented);
    sum += test::nees(pose, views);
  }
  RecordProperty("nees", std::to_string(sum / kSeeds));
  EXPECT_GT(sum / kSeeds, 4);  // 5, standard error sqrt(10 / 120) = .29
  EXPECT_LT(sum / kSeeds, 6.5);
}

TEST_P(UnscentedOn, AgreesWithTheLinearOne) {
  for (int seed = 1; seed <= 5; ++seed) {
    const TwoViews views = two_views({kTurn, GetParam().step}, GetParam().scene, seed);
    const RelativePose linear = refine(views, RelativePoseCovariance::kLinear);
    const RelativePose unscented = refine(views, RelativePoseCovariance::kUnscented);
    EXPECT_EQ(linear.direction, unscented.direction);
    const Vector5d ratio = ratios(unscented.covariance, linear.covariance);
    EXPECT_GT(ratio.minCoeff(), 0.6) << ratio.transpose();
    EXPECT_LT(ratio.maxCoeff(), 1.6) << ratio.transpose();
  }
}

// The same scene with its noise drawn anew: the scatter that both covariances foretell.
TEST_P(UnscentedOn, ForetellsTheScatterOfNewNoise) {
  SceneOptions exact = GetParam().scene;
  exact.noise_px = 0;
  const TwoViews truth = two_views({kTurn, GetParam().step}, exact, 1);
  constexpr int kDraws = 600, kForetold = 20;
  Matrix5d scatter = Matrix5d::Zero(), linear = Matrix5d::Zero(), unscented = Matrix5d::Zero();
  test::Random random(7);
  TwoViews noisy = truth;
  for (int draw = 0; draw < kDraws; ++draw) {
    for (std::size_t k = 0; k < truth.matches.size(); ++k) {
      const Correspondence& m = truth.matches[k];
      noisy.matches[k].x_i = m.x_i + m.sigma_i * random.normal_vector<2>();
      noisy.matches[k].x_j = m.x_j + m.sigma_j * random.normal_vector<2>();
    }
    const RelativePose pose = refine(noisy, RelativePoseCovariance::kLinear);
    const Vector5d error = test::error_of(pose, truth);
    scatter += error * error.transpose() / kDraws;
    if (draw >= kForetold) continue;
    linear += pose.covariance / kForetold;
    unscented += refine(noisy, RelativePoseCovariance::kUnscented).covariance / kForetold;
  }
  // Of 600 draws a variance is known to 6 %; the extremes of five ratios are some 15 % off.
  for (const Matrix5d& foretold : {linear, unscented}) {
    const Vector5d ratio = ratios(scatter, foretold);
    EXPECT_GT(ratio.minCoeff(), 0.6) << ratio.transpose();
    EXPECT_LT(ratio.maxCoeff(), 1.5) << ratio.transpose();
  }
}

// The directions are along no axis, so that neighbouring ones have neighbouring tangent bases.
INSTANTIATE_TEST_SUITE_P(GoodGeometry, UnscentedOn,
                         testing::Values(Scene{"Sideways", {1.5, 0.2, 0.1}, {.number = 100}},
                                         Scene{"Forward", {0.1, 0.2, 1.5}, {.number = 100}},
                                         Scene{"Oblique", {1, 0.3, 1}, {.number = 100}}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Unscented, IsTheSameByOptionInTheWholeEstimate) {
  const TwoViews views = two_views({kTurn, {1, 0, 0}}, {.number = 80, .outliers = 0.2}, 1);
  RelativePoseOptions options;
  const RelativePoseResult linear =
      estimate_relative_pose(views.matches, test::kRadiansPerPixel, options);
  options.covariance = RelativePoseCovariance::kUnscented;
  const RelativePoseResult unscented =
      estimate_relative_pose(views.matches, test::kRadiansPerPixel, options);
  ASSERT_TRUE(linear.ok() && unscented.ok());
  EXPECT_EQ(linear.pose.direction, unscented.pose.direction);
  EXPECT_EQ(linear.inlier, unscented.inlier);
  EXPECT_NE(linear.pose.covariance, unscented.pose.covariance);
  EXPECT_GT(unscented.pose.sigma_direction, 0.6 * linear.pose.sigma_direction);
  EXPECT_LT(unscented.pose.sigma_direction, 1.6 * linear.pose.sigma_direction);
}

// Wrong sigmas show in the residuals' spread, and the sigma points must be as wide.
TEST(Unscented, GrowsWithTheRealNoise) {
  const SceneOptions honest{.number = 100};
  SceneOptions optimistic = honest;
  optimistic.noise_px = 2 * honest.sigma_px;
  const auto sigma = [](const SceneOptions& scene) {
    return refine(two_views({kTurn, {1, 0, 0}}, scene, 1), RelativePoseCovariance::kUnscented)
        .sigma_direction;
  };
  EXPECT_NEAR(sigma(optimistic) / sigma(honest), 2, 0.6);
}

}  // namespace
}  // namespace eifmap
