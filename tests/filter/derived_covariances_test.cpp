// Covariances of what is asked for: against numeric derivatives of it and the dense inverse.
#include "filter/derived_covariances.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/dense_system.h"
#include "support/filter_world.h"
#include "support/numeric_jacobian.h"

namespace eifmap::test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Frozen after one solve, so that the dense system is the one that was factored.
FilterOptions frozen() {
  FilterOptions options;
  options.relinearize = Relinearize::kOnce;
  options.gate_sigma = 1e9;
  return options;
}

// (w, dc) that takes `from` to `to`.
Vector6 difference(const Rigid3& from, const Rigid3& to) {
  Vector6 error;
  error << so3_log(from.rotation.conjugate() * to.rotation), to.translation - from.translation;
  return error;
}

class DerivedCovariances : public testing::Test {
 protected:
  explicit DerivedCovariances(bool metric = false)
      : world_(make_filter_world({.num_poses = 7, .num_points = 60, .seed = 8}, frozen())) {
    filter_.update();
    if (!metric) return;
    Random random(3);
    filter_.make_metric(2);
    filter_.set_earth_from_map(earth_);
    for (int p = 0; p < filter_.num_poses(); ++p)
      filter_.add_absolute(
          AbsoluteObservation::position(
              {p}, earth_ * filter_.pose(p).translation + 0.1 * random.normal_vector<3>(),
              0.01 * Eigen::Matrix3d::Identity()),
          false);
    filter_.update();
  }

  // The dense inverse, of the poses `of` (kEarthFromMap too), zero for the gauge.
  Eigen::MatrixXd joint(const std::vector<int>& of) {
    if (inverse_.size() == 0) inverse_ = dense_covariance(filter_, world_.poses[1].translation);
    const auto n = static_cast<Eigen::Index>(of.size());
    Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(6 * n, 6 * n);
    for (Eigen::Index r = 0; r < n; ++r)
      for (Eigen::Index c = 0; c < n; ++c) {
        const int a = of[static_cast<std::size_t>(r)], b = of[static_cast<std::size_t>(c)];
        if (a != 0 && b != 0)
          joint.block<6, 6>(6 * r, 6 * c) =
              inverse_.block<6, 6>(6 * filter_.blocks().of(a), 6 * filter_.blocks().of(b));
      }
    return joint;
  }

  FilterWorld world_;
  InformationFilter& filter_ = world_.filter;
  Rigid3 earth_{so3_exp({0.4, -1.1, 2}), {500, -200, 30}};
  Eigen::MatrixXd inverse_;
};

class DerivedCovariancesInMetres : public DerivedCovariances {
 protected:
  DerivedCovariancesInMetres() : DerivedCovariances(true) {}
};

void expect_near(const Eigen::MatrixXd& value, const Eigen::MatrixXd& expected) {
  EXPECT_LT((value - expected).norm(), 1e-8 * expected.norm());
}

void expect_right_relative_covariance(const InformationFilter& filter, int a, int b,
                                      const Eigen::MatrixXd& joint) {
  const Rigid3 now = filter.pose(a).inverse() * filter.pose(b);
  const auto moved = [&](const Eigen::Matrix<double, 12, 1>& delta) {
    const Rigid3 pose_a = retract(filter.pose(a), delta.segment<3>(0), delta.segment<3>(3));
    const Rigid3 pose_b = retract(filter.pose(b), delta.segment<3>(6), delta.segment<3>(9));
    return difference(now, pose_a.inverse() * pose_b);
  };
  const auto jacobian = numeric_jacobian<6, 12>(moved, 1e-5);
  PoseBlock covariance;
  ASSERT_TRUE(relative_covariance(filter, a, b, covariance));
  expect_near(covariance, jacobian * joint * jacobian.transpose());
}

TEST_F(DerivedCovariances, OfTwoPosesToEachOther) {
  for (const auto& [a, b] : {std::pair(2, 5), std::pair(5, 2), std::pair(0, 4), std::pair(6, 1)})
    expect_right_relative_covariance(filter_, a, b, joint({a, b}));
  PoseBlock of_itself;
  ASSERT_TRUE(relative_covariance(filter_, 3, 3, of_itself));
  EXPECT_TRUE(of_itself.isZero(0));
}

TEST_F(DerivedCovariancesInMetres, OfTwoPosesToEachOther) {
  expect_right_relative_covariance(filter_, 2, 5, joint({2, 5}));
  expect_right_relative_covariance(filter_, 6, 0, joint({6, 0}));
}

// Neighbours are surer of each other than either is of its place in the map, at a path's end.
TEST_F(DerivedCovariancesInMetres, NeighboursAreSurerOfEachOtherThanOfTheirPlace) {
  PoseBlock relative, in_map;
  ASSERT_TRUE(relative_covariance(filter_, 5, 6, relative));
  ASSERT_TRUE(filter_.pose_covariance(6, in_map));
  const auto size = [](const PoseBlock& covariance) {
    return covariance.bottomRightCorner<3, 3>().trace();
  };
  EXPECT_LT(size(relative), 0.5 * size(in_map));
}

TEST_F(DerivedCovariancesInMetres, OfAPoseInEarth) {
  for (const int p : {0, 3, 6}) {
    const Rigid3 now = filter_.earth_from_map() * filter_.pose(p);
    const auto moved = [&](const Eigen::Matrix<double, 12, 1>& delta) {
      const Rigid3 earth =
          retract(filter_.earth_from_map(), delta.segment<3>(0), delta.segment<3>(3));
      return difference(now,
                        earth * retract(filter_.pose(p), delta.segment<3>(6), delta.segment<3>(9)));
    };
    // Centres are hundreds of metres from earth's origin: of those the digits are.
    const auto jacobian = numeric_jacobian<6, 12>(moved, 1e-4);
    PoseBlock covariance;
    ASSERT_TRUE(covariance_in_earth(filter_, p, covariance));
    expect_near(covariance, jacobian * joint({kEarthFromMap, p}) * jacobian.transpose());
  }
}

TEST_F(DerivedCovariancesInMetres, OfALandmarkInEarth) {
  joint({});
  const Eigen::Index size = inverse_.rows();
  const Eigen::Index n = 6 * filter_.blocks().count(filter_.num_poses());
  for (int l = 0; l < filter_.num_landmarks(); l += 7) {
    const Eigen::Matrix3d turn = filter_.earth_from_map().matrix();
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, size);
    jacobian.middleCols<3>(n + 3 * l) = turn;
    jacobian.middleCols<3>(6 * filter_.blocks().earth()) = -turn * skew(filter_.position(l));
    jacobian.middleCols<3>(6 * filter_.blocks().earth() + 3).setIdentity();
    Eigen::Matrix3d covariance;
    ASSERT_TRUE(landmark_covariance_in_earth(filter_, l, covariance));
    expect_near(covariance, jacobian * inverse_ * jacobian.transpose());
  }
}

TEST_F(DerivedCovariancesInMetres, OfTheScaleThatSomePosesShow) {
  const std::vector<int> poses{3, 4, 6};
  // What scaling by e^s does to the centres is found again as s.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int p : poses) mean += filter_.pose(p).translation / 3;
  double squared = 0;
  for (const int p : poses) squared += (filter_.pose(p).translation - mean).squaredNorm();
  Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, 18);
  for (int k = 0; k < 3; ++k)
    row.middleCols<3>(6 * k + 3) =
        (filter_.pose(poses[static_cast<std::size_t>(k)]).translation - mean).transpose() / squared;
  double variance = 0;
  ASSERT_TRUE(log_scale_variance(filter_, poses, variance));
  EXPECT_NEAR(variance, (row * joint(poses) * row.transpose())(0, 0), 1e-8 * variance);
  EXPECT_FALSE(log_scale_variance(filter_, {3}, variance)) << "one place has no size";
}

TEST_F(DerivedCovariances, AreNotKnownOfWhatTheFilterDoesNotKnow) {
  const int fresh = filter_.add_pose(world_.poses[6]);
  PoseBlock covariance;
  Eigen::Matrix3d of_point;
  double variance = 0;
  EXPECT_FALSE(relative_covariance(filter_, 2, fresh, covariance));
  EXPECT_FALSE(log_scale_variance(filter_, {2, fresh}, variance));
  EXPECT_FALSE(covariance_in_earth(filter_, 2, covariance)) << "no earth";
  EXPECT_FALSE(landmark_covariance_in_earth(filter_, 2, of_point));
}

}  // namespace
}  // namespace eifmap::test
