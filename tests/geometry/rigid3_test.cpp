#include "geometry/rigid3.h"

#include <gtest/gtest.h>

#include "support/numeric_jacobian.h"
#include "support/random.h"

namespace eifmap {
namespace {

using test::numeric_jacobian;
using test::Random;
using test::relative_difference;

TEST(Rigid3, ComposesAndInverts) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Rigid3 a_from_b(random.rotation(), random.normal_vector<3>());
    const Rigid3 b_from_c(random.rotation(), random.normal_vector<3>());
    const Eigen::Vector3d x = random.normal_vector<3>();
    EXPECT_LT(((a_from_b * b_from_c) * x - a_from_b * (b_from_c * x)).norm(), 1e-13);
    EXPECT_LT((a_from_b.inverse() * (a_from_b * x) - x).norm(), 1e-13);
    EXPECT_LT((a_from_b.matrix() * x + a_from_b.translation - a_from_b * x).norm(), 1e-13);
  }
}

TEST(Rigid3, SkewIsTheCrossProduct) {
  const Eigen::Vector3d a(1, -2, 3), b(0.5, 4, -1);
  EXPECT_LT((skew(a) * b - a.cross(b)).norm(), 1e-15);
}

// Angles from zero over the series' limits to just short of half a turn.
TEST(So3, LogUndoesExp) {
  Random random(2);
  for (double angle : {0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 0.01, 1.0, 3.0, M_PI - 1e-6}) {
    const Eigen::Vector3d w = angle * random.unit_vector();
    EXPECT_LT((so3_log(so3_exp(w)) - w).norm(), 1e-9 * std::max(1e-3, angle)) << angle;
    EXPECT_NEAR(so3_exp(w).norm(), 1, 1e-15);
  }
}

TEST(So3, LogTakesTheShortWay) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Quaterniond q = random.rotation();
    const Eigen::Quaterniond minus_q(-q.coeffs());
    EXPECT_LE(so3_log(q).norm(), M_PI + 1e-12);
    EXPECT_LT((so3_log(q) - so3_log(minus_q)).norm(), 1e-12);
    EXPECT_LT(so3_exp(so3_log(q)).angularDistance(q), 1e-7);
  }
}

TEST(So3, RightJacobianInverseIsTheLogsDerivative) {
  Random random(4);
  for (double angle : {0.0, 1e-6, 1e-3, 0.1, 1.0, 2.5}) {
    const Eigen::Vector3d w = angle * random.unit_vector();
    const auto log_of_product = [&](const Eigen::Vector3d& d) {
      return so3_log(so3_exp(w) * so3_exp(d));
    };
    const Eigen::Matrix3d numeric = numeric_jacobian<3, 3>(log_of_product);
    EXPECT_LT(relative_difference(so3_right_jacobian_inverse(w), numeric), 1e-6) << angle;
  }
}

TEST(Pose, RetractTurnsInTheCameraAndMovesInTheWorld) {
  const Rigid3 pose(so3_exp({0, M_PI / 2, 0}), {1, 2, 3});
  const Rigid3 moved = retract(pose, {0, 0, 0.1}, {0, 0, 1});
  EXPECT_LT((moved.translation - Eigen::Vector3d(1, 2, 4)).norm(), 1e-15);
  // A turn about the camera's own axis leaves that axis where it was.
  const Eigen::Vector3d axis = pose.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((moved.rotation * Eigen::Vector3d::UnitZ() - axis).norm(), 1e-15);
  EXPECT_NEAR(moved.rotation.angularDistance(pose.rotation), 0.1, 1e-12);
}

TEST(Sphere, BasisIsOrthonormalAndTangent) {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d t = i < 3 ? Eigen::Vector3d::Unit(i).eval() : random.unit_vector();
    const Eigen::Matrix<double, 3, 2> basis = sphere_basis(t);
    EXPECT_LT((basis.transpose() * basis - Eigen::Matrix2d::Identity()).norm(), 1e-14);
    EXPECT_LT((basis.transpose() * t).norm(), 1e-14);
  }
}

TEST(Sphere, RetractMovesByTheAngleAskedFor) {
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d t = random.unit_vector();
    const Eigen::Vector2d ab = random.uniform(0, 1.5) * random.normal_vector<2>().normalized();
    const Eigen::Vector3d moved = sphere_retract(t, ab);
    EXPECT_NEAR(moved.norm(), 1, 1e-14);
    EXPECT_NEAR(std::atan2(t.cross(moved).norm(), t.dot(moved)), ab.norm(), 1e-12);
  }
  EXPECT_EQ(sphere_retract(Eigen::Vector3d::UnitX(), {0, 0}), Eigen::Vector3d::UnitX());
}

TEST(Sphere, BasisIsTheRetractionsDerivative) {
  Random random(7);
  const Eigen::Vector3d t = random.unit_vector();
  const auto retracted = [&](const Eigen::Vector2d& ab) { return sphere_retract(t, ab); };
  const Eigen::Matrix<double, 3, 2> numeric = numeric_jacobian<3, 2>(retracted);
  EXPECT_LT(relative_difference(sphere_basis(t), numeric), 1e-8);
}

}  // namespace
}  // namespace eifmap
