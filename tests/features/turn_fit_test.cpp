#include "features/turn_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "geometry/rigid3.h"

namespace eifmap {
namespace {

using Eigen::Vector3d;

constexpr double kNoise = 1e-3;  // rad
constexpr double kDegree = 0.0174533;

// Points in front of camera a, as seen from there and from b; some pairs are wrong.
struct Scene {
  std::mt19937 random;
  std::vector<Vector3d> points;

  explicit Scene(unsigned seed) : random(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  Vector3d noise() {
    std::normal_distribution<double> normal(0, kNoise);
    return {normal(random), normal(random), normal(random)};
  }
  std::vector<BearingPair> pairs(const Rigid3& a_from_b, double wrong) {
    std::vector<BearingPair> pairs;
    for (const Vector3d& x : points) {
      const Vector3d& y = uniform(0, 1) < wrong ? points[random() % points.size()] : x;
      pairs.push_back({(x.normalized() + noise()).normalized(),
                       ((a_from_b.inverse() * y).normalized() + noise()).normalized()});
    }
    return pairs;
  }
};

double error(const Turn& turn, const Rigid3& truth) {
  return Eigen::AngleAxisd(turn.rotation.transpose() * truth.rotation.toRotationMatrix()).angle();
}

TEST(TurnFit, FindsTheRotationWhereverTheCameraWent) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Scene scene(seed);
    for (int k = 0; k < 150; ++k) {
      const double z = scene.uniform(3, 10);
      scene.points.push_back({z * scene.uniform(-0.7, 0.7), z * scene.uniform(-0.5, 0.5), z});
    }
    const Vector3d w(scene.uniform(-0.1, 0.1), scene.uniform(-0.1, 0.1), scene.uniform(-0.4, 0.4));
    const Vector3d t(scene.uniform(-0.5, 0.5), scene.uniform(-0.5, 0.5), scene.uniform(-0.5, 0.5));
    const Rigid3 a_from_b(so3_exp(w), t);
    const auto pairs = scene.pairs(a_from_b, 0.1);
    const TurnFit fit = fit_turn(pairs, kNoise, {});
    EXPECT_LT(error(fit.turn, a_from_b), kDegree) << seed;
    EXPECT_GT(fit.num_inliers, 125);
    EXPECT_LT(fit.sigma, 1.5 * kNoise);
    // Starting at the solution stays there.
    EXPECT_LT(error(fit_turn(pairs, kNoise, fit.turn).turn, a_from_b), kDegree) << seed;
  }
}

TEST(TurnFit, NeedsNoParallax) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Scene scene(seed);
    for (int k = 0; k < 100; ++k)
      scene.points.push_back({scene.uniform(-3, 3), scene.uniform(-2, 2), 5});
    const Rigid3 a_from_b(so3_exp({0.05, -0.1, 0.3}), Vector3d::Zero());
    const TurnFit fit = fit_turn(scene.pairs(a_from_b, 0.1), kNoise, {});
    EXPECT_LT(error(fit.turn, a_from_b), 0.5 * kDegree) << seed;
  }
}

// What a fit of a rotation alone would take for 9 degrees of roll.
TEST(TurnFit, AStepAlongsideTheGroundIsNoRoll) {
  Scene scene(3);
  for (int k = 0; k < 150; ++k) {
    const double z = scene.uniform(3, 20);
    scene.points.push_back({z * scene.uniform(-0.3, 0.3), 1.6, z});
  }
  const Rigid3 a_from_b(Eigen::Quaterniond::Identity(), Vector3d(0.7, 0, 0));
  const TurnFit fit = fit_turn(scene.pairs(a_from_b, 0), kNoise, {});
  EXPECT_LT(error(fit.turn, a_from_b), kDegree);
}

TEST(TurnFit, TooFewPairsFitNothing) {
  EXPECT_EQ(fit_turn({}, kNoise, {}).num_inliers, 0);
  const std::vector<BearingPair> few(7, {Vector3d::UnitZ(), Vector3d::UnitZ()});
  EXPECT_EQ(fit_turn(few, kNoise, {}).num_inliers, 0);
  const std::vector<BearingPair> one_place(20, {Vector3d::UnitZ(), Vector3d::UnitZ()});
  EXPECT_TRUE(fit_turn(one_place, kNoise, {}).turn.rotation.allFinite());
}

}  // namespace
}  // namespace eifmap
