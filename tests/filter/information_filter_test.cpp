#include "filter/information_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "support/dense_system.h"
#include "support/filter_world.h"

namespace eifmap::test {
namespace {

TEST(InformationFilter, FindsTheTruthWithoutNoise) {
  FilterWorldOptions options;
  options.noise_px = 1e-6;
  FilterWorld world = make_filter_world(options);
  FilterOptions always;
  const FilterUpdate update = world.filter.update();
  EXPECT_EQ(update.reason, Reason::kNone);
  world.filter.update();
  for (int p = 0; p < options.num_poses; ++p)
    EXPECT_LT(pose_error(world.poses[p], world.filter.pose(p)).norm(), 1e-4) << p;
}

TEST(InformationFilter, SchurComplementIsExact) {
  FilterOptions once;  // one solve, nothing linearized again: the frozen system stays inspectable
  once.relinearize = Relinearize::kOnce;
  once.gate_sigma = 1e9;
  FilterWorld world = make_filter_world({.num_poses = 5, .num_points = 40, .seed = 3}, once);
  world.filter.update();
  ASSERT_GT(world.filter.num_landmarks(), 20);

  // After the solve the residuals left are those at the new mean: the right side must vanish but
  // for the gauge's direction.
  const Dense dense = dense_system(world.filter);
  EXPECT_LT(dense.right_side.norm(), 1e-5 * dense.information.diagonal().norm());
}

TEST(InformationFilter, WithoutGaugeTheInformationHasSevenNullDirectionsLess) {
  FilterOptions never;
  never.relinearize_px = never.relinearize_depth = 1e9;
  never.gate_sigma = 1e9;
  FilterWorld world =
      make_filter_world({.num_poses = 4, .num_points = 40, .start_error = 0, .seed = 5}, never);
  world.filter.update();
  const Dense dense = dense_system(world.filter);
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense.information).eigenvalues();
  // Six are gone with the first pose, which is not a variable; the seventh is the scale.
  EXPECT_LT(eigenvalues[0], 1e-4 * eigenvalues[1]);
}

TEST(InformationFilter, PoseErrorsAreAsLargeAsTheFilterSays) {
  double nees = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    FilterWorld world = make_filter_world({.seed = seed});
    ASSERT_EQ(world.filter.update().reason, Reason::kNone);
    for (int p = 4; p < world.filter.num_poses(); p += 3) {
      PoseBlock covariance;
      ASSERT_TRUE(world.filter.pose_covariance(p, covariance));
      // The truth, brought to the filter's gauge: its first baseline has the length of the truth's.
      const auto error = pose_error(world.poses[p], world.filter.pose(p));
      nees += error.dot(covariance.llt().solve(error));
      ++count;
    }
  }
  // Six degrees of freedom; the mean of 90 runs is within 4.5 and 8 but for one run in thousands
  // (poses of one run are correlated, so the band is wider than chi-square's own).
  EXPECT_GT(nees / count, 4.5);
  EXPECT_LT(nees / count, 8.0);
}

TEST(InformationFilter, DropsAWrongSightingAndKeepsTheRest) {
  FilterWorld world = make_filter_world({.seed = 7});
  const Eigen::Vector2d wrong =
      world.filter.landmark(5).measurements[1].x + Eigen::Vector2d(0.1, 0);
  const int pose = world.filter.landmark(5).measurements[1].pose;
  world.filter.remove_measurement(5, pose);
  world.filter.add_measurement(5, pose, wrong, 1.0 / 500);
  const FilterUpdate update = world.filter.update();
  const bool dropped =
      std::any_of(update.dropped.begin(), update.dropped.end(),
                  [&](const auto& d) { return d.landmark == 5 && d.pose == pose; });
  EXPECT_TRUE(dropped);
  EXPECT_LT(update.dropped.size(), world.filter.num_measurements() / 50);
}

TEST(InformationFilter, ARelativePoseEdgeBringsInformation) {
  FilterWorld without = make_filter_world({.num_points = 60, .seed = 9});
  FilterWorld with = make_filter_world({.num_points = 60, .seed = 9});
  for (int p = 2; p < with.filter.num_poses(); ++p) {
    ASSERT_TRUE(with.filter.add_edge(p - 1, p, true_edge(with, p - 1, p, 1e-6)));
  }
  without.filter.update();
  const FilterUpdate update = with.filter.update();
  EXPECT_EQ(update.dropped_edges, 0);
  PoseBlock loose, tight;
  ASSERT_TRUE(without.filter.pose_covariance(8, loose));
  ASSERT_TRUE(with.filter.pose_covariance(8, tight));
  EXPECT_LT(tight.trace(), 0.8 * loose.trace());
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<PoseBlock>(loose - tight).eigenvalues();
  EXPECT_GT(eigenvalues[0], -0.05 * loose.norm());  // information never takes certainty away
}

TEST(InformationFilter, FollowsTheEquationToTheLetterWhenNeverLinearizedAgain) {
  FilterOptions once;
  once.relinearize = Relinearize::kOnce;
  once.gate_sigma = 1e9;
  FilterWorld world = make_filter_world({.num_poses = 5, .num_points = 40, .seed = 11}, once);
  ASSERT_TRUE(world.filter.add_edge(2, 3, true_edge(world, 2, 3, 1e-4)));
  EXPECT_EQ(world.filter.update().iterations, 1);
  const Rigid3 mean = world.filter.pose(4);
  // No new measurement: the mean is where (7) puts it, and stays.
  world.filter.update();
  EXPECT_LT(pose_error(mean, world.filter.pose(4)).norm(), 1e-8);

  // A new one moves the mean, and no Jacobian that was taken before.
  const Eigen::Matrix<double, 2, 6> before = world.filter.landmark(0).measurements[0].d_pose();
  const int landmark = world.filter.add_landmark(world.points[0] + Eigen::Vector3d(0.3, 0, 0),
                                                 Eigen::Matrix3d::Identity());
  for (int p = 0; p < 5; ++p) {
    Eigen::Vector2d x;
    ASSERT_TRUE(project(world.poses[p], world.points[0], x));
    world.filter.add_measurement(landmark, p, x + Eigen::Vector2d(0.01 * p, 0), 0.0002);
  }
  EXPECT_EQ(world.filter.update().iterations, 1);
  EXPECT_GT(pose_error(mean, world.filter.pose(4)).norm(), 1e-5);
  EXPECT_EQ(before, world.filter.landmark(0).measurements[0].d_pose());
  EXPECT_LT(pose_right_side(world.filter, world.poses[1].translation).norm(),
            1e-9 * dense_system(world.filter).scale());
}

TEST(InformationFilter, LinearizingAlwaysEndsAtTheLeastCost) {
  // From a poor start the mean of the first linearization is not the least-squares one.
  FilterWorldOptions poor{.num_poses = 6, .num_points = 80, .start_error = 0.08, .seed = 19};
  FilterOptions options;
  options.gate_sigma = 1e9;
  options.max_iterations = 30;
  const auto cost = [&](Relinearize policy) {
    options.relinearize = policy;
    FilterWorld world = make_filter_world(poor, options);
    world.filter.update();
    double error = 0;
    for (int l = 0; l < world.filter.num_landmarks(); ++l)
      for (const PointMeasurement& m : world.filter.landmark(l).measurements)
        error += std::pow(world.filter.error(l, m), 2);
    return error;
  };
  const double once = cost(Relinearize::kOnce), always = cost(Relinearize::kAlways);
  EXPECT_LT(always, 0.95 * once);
  EXPECT_LT(std::abs(cost(Relinearize::kThreshold) - always), 0.01 * always);
}

TEST(InformationFilter, ALandmarkBehindItsCamerasCostsOnlyItself) {
  FilterWorld world = make_filter_world({.seed = 13});
  const int behind = world.filter.add_landmark({0, 0, -5}, Eigen::Matrix3d::Identity());
  for (int p = 0; p < 3; ++p) world.filter.add_measurement(behind, p, {0, 0}, 0.002);
  EXPECT_EQ(world.filter.update().reason, Reason::kNone);
  EXPECT_TRUE(world.filter.landmark(behind).measurements.empty());
  EXPECT_LT(pose_error(world.poses[8], world.filter.pose(8)).norm(), 0.1);
}

// Edges to the two poses before each, whose errors are `times` what they claim.
FilterWorld world_with_edges(double times, std::uint64_t seed) {
  FilterWorld world = make_filter_world({.num_poses = 30, .seed = seed});
  test::Random random(seed);
  constexpr double kSigma = 2e-3;
  for (int j = 1; j < 30; ++j)
    for (int i = std::max(0, j - 2); i < j; ++i) {
      RelativePose edge = test::true_edge(world, i, j, kSigma * kSigma);
      const Eigen::Vector3d turn = times * kSigma * random.normal_vector<3>();
      edge.i_from_j = edge.i_from_j * so3_exp(turn);
      edge.direction = sphere_retract(edge.direction, times * kSigma * random.normal_vector<2>());
      EXPECT_TRUE(world.filter.add_edge(i, j, edge));
    }
  for (int k = 0; k < 3; ++k) world.filter.update();
  return world;
}

TEST(InformationFilter, EdgesAreTrustedAsFarAsTheMapAgrees) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_LT(world_with_edges(1, seed).filter.edge_variance(), 1.3);
    // 4 times the variance; less shows, since the edges pull the map to themselves.
    const double found = world_with_edges(2, seed).filter.edge_variance();
    EXPECT_GT(found, 1.6);
    EXPECT_LT(found, 6);
  }
}

TEST(InformationFilter, AWrongEdgeGoesWithoutTakingSightsAlong) {
  FilterWorld clean = make_filter_world({.seed = 15});
  FilterWorld disturbed = make_filter_world({.seed = 15});
  RelativePose wrong;  // turned by a third of a radian, and sure of it
  wrong.i_from_j = so3_exp({0, 0.3, 0});
  wrong.direction = Eigen::Vector3d::UnitY();
  wrong.covariance.setIdentity();
  wrong.covariance *= 1e-8;
  ASSERT_TRUE(disturbed.filter.add_edge(5, 6, wrong));
  const FilterUpdate expected = clean.filter.update();
  const FilterUpdate update = disturbed.filter.update();
  EXPECT_EQ(update.dropped_edges, 1);
  EXPECT_EQ(disturbed.filter.num_edges(), 0);
  EXPECT_LE(update.dropped.size(), expected.dropped.size() + 2);
  EXPECT_LT(pose_error(clean.filter.pose(6), disturbed.filter.pose(6)).norm(), 1e-2);
}

TEST(InformationFilter, ScaledSigmasScaleTheCovariancesAndMoveNothing) {
  FilterOptions options;
  options.huber_sigma = options.gate_sigma = 100;  // weights do not change
  options.judge_edges = false;
  options.relinearize = Relinearize::kAlways;
  FilterWorld world = make_filter_world({}, options);
  world.filter.add_edge(2, 7, true_edge(world, 2, 7, 1e-6));
  for (int i = 0; i < 3; ++i) world.filter.update();
  const int last = world.filter.num_poses() - 1;
  PoseBlock before, after;
  ASSERT_TRUE(world.filter.pose_covariance(last, before));
  const Rigid3 pose = world.filter.pose(last);
  world.filter.scale_sigmas(3);
  ASSERT_EQ(world.filter.update().reason, Reason::kNone);
  ASSERT_TRUE(world.filter.pose_covariance(last, after));
  EXPECT_LT((after - 9 * before).norm(), 1e-3 * after.norm());
  EXPECT_LT(pose_error(pose, world.filter.pose(last)).norm(), 1e-3 * std::sqrt(before.trace()));
  EXPECT_THROW(world.filter.scale_sigmas(0), std::invalid_argument);
}

TEST(InformationFilter, KnowsNoCovarianceBeforeItHasSolved) {
  FilterWorld world = make_filter_world({.seed = 17});
  PoseBlock covariance;
  EXPECT_FALSE(world.filter.pose_covariance(3, covariance));
}

TEST(InformationFilter, RefusesMisuse) {
  InformationFilter filter({}, 0.002);
  const int landmark = filter.add_landmark({0, 0, 5}, Eigen::Matrix3d::Identity());
  EXPECT_THROW(filter.add_measurement(landmark, 0, {0, 0}, 1), std::invalid_argument);
  filter.add_pose({});
  EXPECT_THROW(filter.add_measurement(landmark, 0, {0, 0}, 0), std::invalid_argument);
  EXPECT_THROW(filter.add_edge(0, 0, RelativePose()), std::invalid_argument);
  EXPECT_THROW(filter.add_edge(0, 1, RelativePose()), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
