#include <gtest/gtest.h>

#include "support/dense_system.h"
#include "support/filter_world.h"

namespace eifmap::test {
namespace {

// Frozen after one solve, so that the dense system is the one that was factored.
FilterOptions frozen() {
  FilterOptions options;
  options.relinearize = Relinearize::kOnce;
  options.gate_sigma = 1e9;
  return options;
}

class Covariance : public testing::Test {
 protected:
  Covariance()
      : world_(make_filter_world({.num_poses = 6, .num_points = 50, .seed = 21}, frozen())) {
    world_.filter.add_edge(1, 4, true_edge(world_, 1, 4, 1e-5));
    world_.filter.update();
    inverse_ = dense_covariance(world_.filter, world_.poses[1].translation);
  }

  static void expect_near(const Eigen::MatrixXd& value, const Eigen::MatrixXd& expected) {
    EXPECT_LT((value - expected).norm(), 1e-8 * expected.norm());
  }

  FilterWorld world_;
  Eigen::MatrixXd inverse_;
};

TEST_F(Covariance, OfAPoseIsItsBlockOfTheInverse) {
  for (int p = 1; p < world_.filter.num_poses(); ++p) {
    PoseBlock covariance;
    ASSERT_TRUE(world_.filter.pose_covariance(p, covariance));
    expect_near(covariance, inverse_.block<6, 6>(6 * (p - 1), 6 * (p - 1)));
  }
  PoseBlock gauge;
  ASSERT_TRUE(world_.filter.pose_covariance(0, gauge));
  EXPECT_TRUE(gauge.isZero(0));
}

TEST_F(Covariance, OfALandmarkIsItsBlockOfTheInverse) {
  const int n = 6 * (world_.filter.num_poses() - 1);
  for (int l = 0; l < world_.filter.num_landmarks(); l += 7) {
    Eigen::Matrix3d covariance;
    ASSERT_TRUE(world_.filter.landmark_covariance(l, covariance));
    expect_near(covariance, inverse_.block<3, 3>(n + 3 * l, n + 3 * l));
    // That given the poses is smaller, and is not what a user is told.
    EXPECT_GT(covariance.trace(), 1.01 * world_.filter.landmark(l).covariance.trace());
  }
}

TEST_F(Covariance, OfManyAtOnceIsThatOfEach) {
  const std::vector<int> poses{4, 2, 0}, landmarks{9, 3};
  std::vector<PoseBlock> of_poses;
  std::vector<Eigen::Matrix3d> of_landmarks;
  ASSERT_TRUE(world_.filter.covariances(poses, landmarks, of_poses, of_landmarks));
  ASSERT_EQ(of_poses.size(), poses.size());
  ASSERT_EQ(of_landmarks.size(), landmarks.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    PoseBlock alone;
    ASSERT_TRUE(world_.filter.pose_covariance(poses[k], alone));
    EXPECT_LE((of_poses[k] - alone).norm(), 1e-9 * (alone.norm() + 1e-9));
  }
  for (std::size_t k = 0; k < landmarks.size(); ++k) {
    Eigen::Matrix3d alone;
    ASSERT_TRUE(world_.filter.landmark_covariance(landmarks[k], alone));
    expect_near(of_landmarks[k], alone);
  }
}

TEST_F(Covariance, OfALinearFunctionOfPoses) {
  const PoseSensitivity a{2, 3 * PoseBlock::Identity()}, b{5, PoseBlock::Random()};
  PoseBlock covariance;
  ASSERT_TRUE(world_.filter.propagate({a, b, {0, PoseBlock::Random()}}, covariance));
  const auto block = [this](int p, int q) {
    return inverse_.block<6, 6>(6 * (p - 1), 6 * (q - 1));
  };
  const PoseBlock cross = 3 * block(2, 5) * b.derivative.transpose();
  const PoseBlock expected = 9 * block(2, 2) +
                             b.derivative * block(5, 5) * b.derivative.transpose() + cross +
                             cross.transpose();
  expect_near(covariance, expected);
}

TEST_F(Covariance, IsNotKnownOfWhatCameAfterTheUpdate) {
  const int pose = world_.filter.add_pose(world_.poses[5]);
  PoseBlock covariance;
  EXPECT_FALSE(world_.filter.pose_covariance(pose, covariance));
  EXPECT_FALSE(world_.filter.propagate({{pose, PoseBlock::Identity()}}, covariance));
  const int landmark = world_.filter.add_landmark(world_.points[0], Eigen::Matrix3d::Identity());
  world_.filter.add_measurement(landmark, pose, {0, 0}, 0.002);
  Eigen::Matrix3d of_landmark;
  EXPECT_FALSE(world_.filter.landmark_covariance(landmark, of_landmark));
}

// A filter that never had what the other has removed: its poses in use, and what is measured of
// them.
InformationFilter without_removed(const InformationFilter& filter, double pixel) {
  InformationFilter fresh(FilterOptions{}, pixel);
  std::vector<int> now(static_cast<std::size_t>(filter.num_poses()), -1);
  for (int p = 0; p < filter.num_poses(); ++p)
    if (!filter.is_removed(p)) now[static_cast<std::size_t>(p)] = fresh.add_pose(filter.pose(p));
  for (const FilterLandmark& landmark : filter.landmarks()) {
    if (landmark.is_removed()) continue;
    const int l = fresh.add_landmark(landmark.position, landmark.covariance);
    for (const PointMeasurement& m : landmark.measurements)
      fresh.add_measurement(l, now[static_cast<std::size_t>(m.pose)], m.x, m.sigma);
  }
  return fresh;
}

// Of a long run most poses are removed ones, and the matrix is of the others alone.
TEST(CovarianceOfALongRun, KnowsNothingOfRemovedPoses) {
  FilterWorldOptions options{.num_poses = 60, .num_points = 600, .seed = 5};
  options.start_error = 1e-3;
  FilterWorld world = make_filter_world(options);
  InformationFilter& filter = world.filter;
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  for (int p = 2; p < 58; p += 2) {
    filter.remove_pose(p);
    for (int l = 0; l < filter.num_landmarks(); ++l)
      if (filter.landmark(l).measurements.size() == 1) filter.remove_landmark(l);
    if (p % 6 == 0) {
      ASSERT_EQ(filter.update().reason, Reason::kNone);
    }
  }
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  EXPECT_LT(filter.blocks().count(filter.num_poses()), 60 - 28 + 16);
  InformationFilter fresh = without_removed(filter, options.pixel);
  ASSERT_EQ(fresh.update().reason, Reason::kNone);
  int q = 0;
  for (int p = 0; p < filter.num_poses(); ++p) {
    PoseBlock have, want;
    ASSERT_EQ(filter.pose_covariance(p, have), !filter.is_removed(p));
    if (filter.is_removed(p)) continue;
    ASSERT_TRUE(fresh.pose_covariance(q, want));
    if (p > 1) {  // the gauge's direction is a little another one
      const auto off = pose_error(fresh.pose(q), filter.pose(p));
      EXPECT_LT(off.dot(want.ldlt().solve(off)), 0.01) << p;
    }
    EXPECT_LE((have / filter.variance() - want / fresh.variance()).norm(),
              4e-2 * want.norm() / fresh.variance())
        << p;
    ++q;
  }
}

}  // namespace
}  // namespace eifmap::test
