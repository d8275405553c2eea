#include <gtest/gtest.h>

#include "motion/relative_pose.h"
#include "support/synthetic_scene.h"

namespace eifmap {
namespace {

using test::kRadiansPerPixel;
using test::SceneOptions;
using test::two_views;
using test::TwoViews;

constexpr double kDegree = M_PI / 180;

TEST(RotationFit, FindsARotationAmongWrongMatches) {
  for (double outliers : {0.0, 0.3, 0.5})
    for (int seed = 1; seed <= 20; ++seed) {
      const TwoViews views = two_views({so3_exp({0.1, -0.2, 0.15}), {0, 0, 0}},
                                       {.number = 200, .outliers = outliers}, seed);
      const RotationFit fit = fit_rotation(views.matches, kRadiansPerPixel, {});
      EXPECT_LT(fit.i_from_j.angularDistance(views.i_from_j.rotation), 0.1 * kDegree);
      int missed = 0, wrong = 0;
      for (std::size_t k = 0; k < views.right.size(); ++k) {
        missed += views.right[k] && !fit.inlier[k];
        wrong += !views.right[k] && fit.inlier[k];
      }
      EXPECT_LT(missed, 30) << seed;
      EXPECT_LT(wrong, 3) << seed;
    }
}

TEST(RotationFit, MeasuresTheParallaxThatIsLeft) {
  const TwoViews still = two_views({so3_exp({0.1, 0, 0}), {0, 0, 0}}, {.number = 300}, 1);
  // Two points' noise of .7 px each: the norm's median is .7 sqrt(2) 1.18 px on the axis, less off
  // it.
  EXPECT_NEAR(fit_rotation(still.matches, kRadiansPerPixel, {}).median_parallax / kRadiansPerPixel,
              1.05, 0.15);
  const TwoViews step = two_views({so3_exp({0.1, 0, 0}), {1, 0, 0}}, {.number = 300}, 1);
  EXPECT_GT(fit_rotation(step.matches, kRadiansPerPixel, {}).median_parallax / kRadiansPerPixel, 8);
}

TEST(RotationFit, OfTooFewIsTheIdentity) {
  const RotationFit fit = fit_rotation({}, kRadiansPerPixel, {});
  EXPECT_EQ(fit.num_inliers, 0);
  EXPECT_EQ(fit.i_from_j.w(), 1);
}

TEST(RotationFit, SurvivesMatchesThatAllCoincide) {
  const std::vector<Correspondence> same(20, {{0.1, 0.1}, {0.1, 0.1}, 0.001, 0.001});
  const RotationFit fit = fit_rotation(same, kRadiansPerPixel, {});
  EXPECT_TRUE(fit.i_from_j.coeffs().allFinite());
  EXPECT_EQ(fit.num_inliers, 20);
}

}  // namespace
}  // namespace eifmap
