#include "motion/scale_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <stdexcept>

#include "support/synthetic_scene.h"

namespace eifmap {
namespace {

using test::kRadiansPerPixel;
using test::map_view;
using test::Random;
using test::SceneOptions;

constexpr double kDegree = M_PI / 180;

// A step of a camera against its map. The guess has the relative pose's rotation and direction,
// which are a little off, and a length of its own.
struct Step {
  Rigid3 world_from_i, world_from_j, guess;
  std::vector<MapObservation> observations;
};

struct StepOptions {
  Eigen::Vector3d step{1, 0, 0};
  double guess_length = 1;
  double rotation_error_deg = 0.05, direction_error_deg = 0.5;
  SceneOptions scene{};
};

Step make_step(const StepOptions& options, std::uint64_t seed) {
  Random random(seed);
  Step s;
  s.world_from_i = {random.rotation(), 5 * random.normal_vector<3>()};
  s.world_from_j = s.world_from_i * Rigid3(so3_exp({0.02, -0.05, 0.01}), options.step);
  s.observations = map_view(s.world_from_j, options.scene, seed + 100000);
  const Eigen::Vector2d tilt =
      options.direction_error_deg * kDegree * random.normal_vector<2>().normalized();
  const Eigen::Vector3d direction = sphere_retract(options.step.normalized(), tilt);
  s.guess = {s.world_from_j.rotation *
                 so3_exp(options.rotation_error_deg * kDegree * random.unit_vector()),
             s.world_from_i * Eigen::Vector3d(options.guess_length * direction)};
  return s;
}

ScaleFit fit(const Step& s, const ScaleFitOptions& options = {}) {
  return fit_scale(s.world_from_i.translation, s.guess, s.observations, options);
}

bool within_ten_percent(const ScaleFit& result, const StepOptions& options) {
  const double truth = options.step.norm();
  return result.d < 1 && std::abs(result.baseline - truth) < 0.1 * truth;
}

struct Case {
  const char* name;
  Eigen::Vector3d step;
  double guess_length, outliers;
};

void PrintTo(const Case& test, std::ostream* out) {
  *out << test.name;
}

class ScaleFitOn : public testing::TestWithParam<Case> {};

TEST_P(ScaleFitOn, FindsTheBaseline) {
  constexpr int kSeeds = 100;
  StepOptions options{.step = GetParam().step, .guess_length = GetParam().guess_length};
  options.scene.outliers = GetParam().outliers;
  ScaleFitOptions accepting;
  accepting.min_inlier_ratio = 0.2;  // at 70 % wrong the default of .3 refuses every other one
  int good = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const ScaleFit result = fit(make_step(options, seed), accepting);
    good += result.ok() && within_ten_percent(result, options);
  }
  EXPECT_GE(good, 98);
}

INSTANTIATE_TEST_SUITE_P(
    Outliers, ScaleFitOn,
    testing::Values(Case{"Sideways30", {1, 0, 0}, 1, 0.3}, Case{"Forward30", {0, 0, 1}, 1, 0.3},
                    Case{"Sideways50", {1, 0, 0}, 1, 0.5}, Case{"Forward50", {0, 0, 1}, 1, 0.5},
                    Case{"Sideways70", {1, 0, 0}, 1, 0.7}, Case{"Forward70", {0, 0, 1}, 1, 0.7},
                    // After a stop the guess is as short as it may be; after a sprint far too long.
                    Case{"GuessTooShort", {1, 0, 0}, 0.05, 0.5},
                    Case{"GuessTooLong", {0, 0, 1}, 20, 0.5},
                    // Short: a twentieth of the depth
                    Case{"ShortStep", {0.3, 0, 0}, 1, 0.3}),
    [](const auto& test) { return std::string(test.param.name); });

// Fits within 10 % of the truth, of 100.
int good_fits(const StepOptions& options, ScaleFitMethod method) {
  ScaleFitOptions fit_options;
  fit_options.method = method;
  int good = 0;
  for (int seed = 1; seed <= 100; ++seed)
    good += within_ten_percent(fit(make_step(options, seed), fit_options), options);
  return good;
}

// [WD10] III-D is as good as the votes with few outliers, and breaks down where they do not.
TEST(ScaleFit, ThePlainFitBreaksDownWhereTheVotesDoNot) {
  for (const Eigen::Vector3d& step : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1)}) {
    const bool forward = step.z() > 0;
    // The last step was a fifth longer.
    StepOptions options{.step = step, .guess_length = 1.2};
    int plain[3];
    for (int k = 0; k < 3; ++k) {
      options.scene.outliers = 0.3 + 0.2 * k;
      plain[k] = good_fits(options, ScaleFitMethod::kPlain);
      EXPECT_GE(good_fits(options, ScaleFitMethod::kVote), 97) << forward << ' ' << k;
    }
    RecordProperty(
        forward ? "forward" : "sideways",
        std::to_string(plain[0]) + " " + std::to_string(plain[1]) + " " + std::to_string(plain[2]));
    EXPECT_GE(plain[0], 98) << forward;
    EXPECT_LE(plain[1], 95) << forward;
    EXPECT_LE(plain[2], 40) << forward;
  }
}

TEST(ScaleFit, PlainlyConvergesOnExactData) {
  StepOptions options{.guess_length = 1.5};
  options.rotation_error_deg = options.direction_error_deg = 0;
  options.scene.noise_px = 0;
  ScaleFitOptions plain;
  plain.method = ScaleFitMethod::kPlain;
  const Step s = make_step(options, 2);
  const ScaleFit result = fit(s, plain);
  EXPECT_TRUE(result.ok());
  EXPECT_NEAR(result.baseline, 1, 1e-6);
  EXPECT_EQ(result.runner_up, 0);
}

// [WD10] (3)-(5): 0 is the guess, 1 did not move, above 1 the direction had the wrong sign.
TEST(ScaleFit, MeansByDWhatThePaperMeans) {
  StepOptions options;
  options.rotation_error_deg = options.direction_error_deg = 0;
  options.scene.noise_px = 0;
  Step s = make_step(options, 1);
  EXPECT_NEAR(fit(s).d, 0, 1e-6);

  options.guess_length = 4;
  s = make_step(options, 2);
  EXPECT_NEAR(fit(s).d, 0.75, 1e-6);
  EXPECT_LT((fit(s).world_from_j.translation - s.world_from_j.translation).norm(), 1e-5);
  EXPECT_NEAR(fit(s).baseline, 1, 1e-6);

  options.guess_length = -1;  // the other way
  s = make_step(options, 3);
  const ScaleFit wrong_sign = fit(s);
  EXPECT_TRUE(wrong_sign.ok());
  EXPECT_NEAR(wrong_sign.d, 2, 1e-6);
  EXPECT_LT((wrong_sign.world_from_j.translation - s.world_from_j.translation).norm(), 1e-5);
}

TEST(ScaleFit, RecoversFromTheWrongSignWithNoiseAndOutliers) {
  StepOptions options{.guess_length = -0.7};
  options.scene.outliers = 0.4;
  for (int seed = 1; seed <= 20; ++seed) {
    const Step s = make_step(options, seed);
    const ScaleFit result = fit(s);
    ASSERT_TRUE(result.ok()) << seed;
    EXPECT_GT(result.d, 1);
    EXPECT_NEAR(result.baseline, 1, 0.1);
  }
}

TEST(ScaleFit, RefusesOutliersAlone) {
  StepOptions options;
  options.scene.outliers = 1;
  ScaleFitOptions lenient;
  lenient.min_inlier_ratio = 0.1;
  for (int seed = 1; seed <= 50; ++seed)
    EXPECT_EQ(fit(make_step(options, seed), lenient).reason, Reason::kScaleFitFailed) << seed;
}

// Two groups of features that each hold together, as a moving lorry does: nobody can tell which.
TEST(ScaleFit, RefusesTwoEqualGroups) {
  StepOptions options;
  options.scene.number = 75;
  Step s = make_step(options, 1);
  options.step = {0.5, 0, 0};
  const Step other = make_step(options, 1);  // the same rotation and start
  // What `other` sees of its map, which hangs together at half the baseline.
  s.observations.insert(s.observations.end(), other.observations.begin(), other.observations.end());
  const ScaleFit result = fit(s);
  EXPECT_FALSE(result.ok());
  EXPECT_GT(result.runner_up, 0.7);

  // A third against two thirds is no such doubt.
  s.observations.resize(75 + 35);
  const ScaleFit clear = fit(s);
  EXPECT_TRUE(clear.ok());
  EXPECT_LT(clear.runner_up, 0.7);
  EXPECT_NEAR(clear.baseline, 1, 0.1);
}

TEST(ScaleFit, RefusesAStandstill) {
  StepOptions options;
  Step s = make_step(options, 1);
  // Seen from where i stood: d is 1, the baseline 0 within its sigma.
  s.observations =
      map_view({s.world_from_j.rotation, s.world_from_i.translation}, options.scene, 5);
  const ScaleFit result = fit(s);
  EXPECT_FALSE(result.ok());
  EXPECT_NEAR(result.d, 1, 5 * std::max(result.sigma_d, 0.01));
}

TEST(ScaleFit, SigmaIsHonestGivenTheDirection) {
  StepOptions options;
  options.rotation_error_deg = options.direction_error_deg = 0;
  constexpr int kSeeds = 300;
  for (const Eigen::Vector3d& step : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1)}) {
    options.step = step;
    double sum = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const ScaleFit result = fit(make_step(options, seed));
      sum += std::pow((result.baseline - 1) / result.sigma_baseline, 2);
    }
    EXPECT_GT(sum / kSeeds, 0.7);  // standard error sqrt(2 / 300) = .08
    EXPECT_LT(sum / kSeeds, 1.25);
  }
}

TEST(ScaleFit, InliersAreTheRightOnes) {
  StepOptions options;
  options.scene.outliers = 0;
  Step s = make_step(options, 1);
  for (std::size_t k = 0; k < 60; ++k) s.observations[k].x += Eigen::Vector2d(0.1, 0.1);
  const ScaleFit result = fit(s);
  ASSERT_TRUE(result.ok());
  int wrong = 0, right = 0;
  for (std::size_t k = 0; k < 150; ++k) (k < 60 ? wrong : right) += result.inlier[k];
  EXPECT_LE(wrong, 1);
  EXPECT_GE(right, 85);
  EXPECT_EQ(result.num_inliers, wrong + right);
  EXPECT_NEAR(result.inlier_ratio, result.num_inliers / 150.0, 1e-12);
}

TEST(ScaleFit, OfNothingFails) {
  Step s = make_step({}, 1);
  s.observations.clear();
  EXPECT_EQ(fit(s).reason, Reason::kScaleFitFailed);
}

TEST(ScaleFit, IgnoresTheEpipoleAndWhatIsBehind) {
  StepOptions options{.step = {0, 0, 1}};
  options.rotation_error_deg = options.direction_error_deg = 0;
  Step s = make_step(options, 1);
  // Exactly on the epipole, and behind both cameras
  s.observations.push_back({s.world_from_j * Eigen::Vector3d(0, 0, 5), {0, 0}, 0.001});
  s.observations.push_back({s.world_from_j * Eigen::Vector3d(0.1, 0, -5), {0.1, 0}, 0.001});
  const ScaleFit result = fit(s);
  EXPECT_TRUE(result.ok());
  EXPECT_TRUE(std::isfinite(result.sigma_d));
  EXPECT_EQ(result.inlier.back(), 0);
}

TEST(ScaleFit, ThrowsOnMisuse) {
  const Step s = make_step({}, 1);
  EXPECT_THROW(fit_scale(s.guess.translation, s.guess, s.observations, {}), std::invalid_argument);
  ScaleFitOptions options;
  options.max_spread = 0.5;
  EXPECT_NE(options.problem().find("max_spread"), std::string::npos);
  EXPECT_THROW(fit(s, options), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
