#include "filter/measurement_models.h"

#include <gtest/gtest.h>

#include "support/numeric_jacobian.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Vector3d vector3(Random& random, double size) {
  return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

Rigid3 pose(Random& random) {
  return {so3_exp(vector3(random, 0.5)), vector3(random, 2)};
}

// A measurement of the pair with noise of about `error` rad.
RelativePose measured(Random& random, const Rigid3& i, const Rigid3& j, double error) {
  RelativePose relative;
  const Rigid3 i_from_j = i.inverse() * j;
  relative.i_from_j = (i_from_j.rotation * so3_exp(vector3(random, error))).normalized();
  relative.direction = sphere_retract(i_from_j.translation.normalized(),
                                      error * Eigen::Vector2d(random.normal(), random.normal()));
  Eigen::Matrix<double, 5, 5> a;
  for (int k = 0; k < 25; ++k) a(k / 5, k % 5) = random.normal();
  relative.covariance = 1e-4 * (a * a.transpose() + Eigen::Matrix<double, 5, 5>::Identity());
  return relative;
}

TEST(RelativePoseMeasurement, JacobiansAgreeWithNumericOnes) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3 i = pose(random), j = pose(random);
    RelativePoseMeasurement measurement;
    ASSERT_TRUE(make_measurement(measured(random, i, j, 0.05), measurement));
    RelativePoseLinearization lin;
    ASSERT_TRUE(linearize(measurement, i, j, lin));
    const auto residual = [&](const Rigid3& a, const Rigid3& b) {
      RelativePoseLinearization out;
      EXPECT_TRUE(linearize(measurement, a, b, out));
      return out.residual;
    };
    // The residual is z - h, so its derivative is -H.
    const Eigen::Matrix<double, 5, 6> d_i = -numeric_jacobian<5, 6>(
        [&](const Vector6& d) { return residual(retract(i, d.head<3>(), d.tail<3>()), j); });
    const Eigen::Matrix<double, 5, 6> d_j = -numeric_jacobian<5, 6>(
        [&](const Vector6& d) { return residual(i, retract(j, d.head<3>(), d.tail<3>())); });
    EXPECT_LT(relative_difference(lin.d_i, d_i), 1e-6);
    EXPECT_LT(relative_difference(lin.d_j, d_j), 1e-6);
  }
}

TEST(RelativePoseMeasurement, ResidualIsZeroAtTheMeasuredPair) {
  Random random(2);
  const Rigid3 i = pose(random), j = pose(random);
  RelativePoseMeasurement measurement;
  ASSERT_TRUE(make_measurement(measured(random, i, j, 0), measurement));
  RelativePoseLinearization lin;
  ASSERT_TRUE(linearize(measurement, i, j, lin));
  EXPECT_LT(lin.residual.norm(), 1e-9);
}

TEST(RelativePoseMeasurement, ScaleIsNotMeasured) {
  Random random(3);
  const Rigid3 i = pose(random), j = pose(random);
  RelativePoseMeasurement measurement;
  ASSERT_TRUE(make_measurement(measured(random, i, j, 0.02), measurement));
  RelativePoseLinearization near, far;
  ASSERT_TRUE(linearize(measurement, i, j, near));
  const Rigid3 twice(j.rotation, i.translation + 2 * (j.translation - i.translation));
  ASSERT_TRUE(linearize(measurement, i, twice, far));
  EXPECT_LT((near.residual - far.residual).norm(), 1e-9);
}

TEST(RelativePoseMeasurement, WhitensByItsCovariance) {
  Random random(4);
  const Rigid3 i = pose(random), j = pose(random);
  const RelativePose relative = measured(random, i, j, 0.02);
  RelativePoseMeasurement measurement;
  ASSERT_TRUE(make_measurement(relative, measurement));
  const Eigen::Matrix<double, 5, 5> whitened =
      measurement.sqrt_information * relative.covariance * measurement.sqrt_information.transpose();
  EXPECT_LT((whitened - Eigen::Matrix<double, 5, 5>::Identity()).norm(), 1e-9);
}

TEST(RelativePoseMeasurement, RefusesWhatItCannotUse) {
  Random random(5);
  const Rigid3 i = pose(random), j = pose(random);
  RelativePose relative = measured(random, i, j, 0.02);
  RelativePoseMeasurement measurement;
  ASSERT_TRUE(make_measurement(relative, measurement));
  RelativePoseLinearization lin;
  EXPECT_FALSE(linearize(measurement, i, Rigid3(j.rotation, i.translation), lin));
  relative.covariance.setZero();
  EXPECT_FALSE(make_measurement(relative, measurement));
}

}  // namespace
}  // namespace eifmap::test
