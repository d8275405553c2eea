// Where an update leaves the mean, and what it moves.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "support/dense_system.h"
#include "support/long_way.h"

namespace eifmap::test {
namespace {

// How far the furthest coordinate of a pose or landmark is from where the whole least-squares
// problem wants it, in its sigmas: derivatives taken anew at the filter's mean, nothing eliminated,
// nothing frozen but the robust weights.
double sigmas_from_the_least_squares_mean(const InformationFilter& filter) {
  const int n = 6 * (filter.num_poses() - 1), size = n + 3 * filter.num_landmarks();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
  for (int l = 0; l < filter.num_landmarks(); ++l) {
    for (const PointMeasurement& m : filter.landmark(l).measurements) {
      Eigen::Vector2d predicted;
      Eigen::Matrix<double, 2, 6> d_pose = Eigen::Matrix<double, 2, 6>::Zero();
      Eigen::Matrix<double, 2, 3> d_point = Eigen::Matrix<double, 2, 3>::Zero();
      if (!project(filter.pose(m.pose), filter.position(l), predicted, &d_pose, &d_point)) continue;
      const double weight = m.root / m.sigma;
      d_pose *= weight, d_point *= weight;
      const Eigen::Vector2d residual = weight * (m.x - predicted);
      information.block<3, 3>(n + 3 * l, n + 3 * l) += d_point.transpose() * d_point;
      gradient.segment<3>(n + 3 * l) += d_point.transpose() * residual;
      if (m.pose == 0) continue;
      const int p = 6 * (m.pose - 1);
      information.block<6, 6>(p, p) += d_pose.transpose() * d_pose;
      information.block<3, 6>(n + 3 * l, p) = d_point.transpose() * d_pose;
      information.block<6, 3>(p, n + 3 * l) = d_pose.transpose() * d_point;
      gradient.segment<6>(p) += d_pose.transpose() * residual;
    }
  }
  const Eigen::Vector3d u = filter.pose(1).translation.normalized();
  const double firm = 1e6 * information.block<3, 3>(3, 3).trace();
  information.block<3, 3>(3, 3) += firm * u * u.transpose();
  gradient.segment<3>(3) -= u * u.dot(gradient.segment<3>(3));
  information.diagonal().array() += 1e-9;  // landmarks that lost their sights have none
  const Eigen::MatrixXd covariance = information.llt().solve(Eigen::MatrixXd::Identity(size, size));
  const Eigen::ArrayXd step = (covariance * gradient).array();
  return (step.abs() / covariance.diagonal().array().sqrt()).maxCoeff();
}

LongWay short_way(std::uint64_t seed) {
  return make_long_way(round_course(35, 1000), {.points_per_pose = 10, .seed = seed});
}

// At moments along the way that the seed draws.
TEST(Settling, LeavesTheMeanWithinAThousandthOfASigmaOfTheLeastSquaresOne) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const LongWay world = short_way(seed);
    FilterOptions options;
    options.gate_sigma = 1e9;  // what an update drops at its end, the next one settles
    LongWayFeed feed(world, options);
    Random random(seed);
    while (!feed.done()) {
      feed.add_next();
      const FilterUpdate update = feed.filter().update();
      if (feed.num_poses() < 6 || random.uniform(0, 1) < 0.85) continue;
      // One that has run out of steps goes on with the next.
      if (update.iterations == options.max_iterations) feed.filter().update();
      EXPECT_LT(sigmas_from_the_least_squares_mean(feed.filter()), 1e-3)
          << "seed " << seed << ", " << feed.num_poses() << " poses";
    }
  }
}

// Frozen derivatives this far off lead to steps that overshoot.
TEST(Settling, EndsAtTheLeastSquaresMeanWhateverIsFrozen) {
  const LongWay world = short_way(7);
  FilterOptions options;
  options.relinearize_px = 3;
  options.relinearize_depth = 0.1;
  options.gate_sigma = options.huber_sigma = 1e9;
  LongWayFeed feed(world, options);
  while (!feed.done()) {
    feed.add_next();
    feed.filter().update();
  }
  for (int k = 0; k < 5; ++k) feed.filter().update();

  EXPECT_LT(sigmas_from_the_least_squares_mean(feed.filter()), 1e-3);
}

TEST(Settling, ANewKeyframeLooksAtLittleOfALongMap) {
  const LongWay world = make_long_way(round_course(150, 1000), {});
  LongWayFeed feed(world, FilterOptions{});
  int updates = 0, local = 0;
  while (!feed.done()) {
    feed.add_next();
    const Rigid3 before = feed.filter().pose(feed.num_poses() / 2);
    const FilterUpdate update = feed.filter().update();
    if (feed.num_poses() < 100) continue;
    EXPECT_EQ(update.reason, Reason::kNone);
    ++updates;
    const Rigid3& now = feed.filter().pose(feed.num_poses() / 2);
    if (before.translation == now.translation) ++local;
  }
  EXPECT_GE(local, updates * 4 / 5) << "of " << updates;
}

// An old pose that sees nothing makes the matrix singular, but not that of the latest poses: they
// have moved when it is found, and so has an old landmark of which the update before dropped a
// wrong sight.
TEST(Settling, AnUpdateThatFailsLeavesTheMeanAsItWas) {
  const LongWay world = make_long_way(round_course(60, 1000), {});
  LongWayFeed feed(world, FilterOptions{});
  InformationFilter& filter = feed.filter();
  while (feed.num_poses() < 59) {
    feed.add_next();
    filter.update();
  }
  int old = 0;
  while (filter.landmark(old).measurements.size() < 3 ||
         filter.landmark(old).measurements.back().pose > 20)
    ++old;
  const PointMeasurement right = filter.landmark(old).measurements.back();
  filter.remove_measurement(old, right.pose);
  filter.add_measurement(old, right.pose, right.x + Eigen::Vector2d(0.02, 0), right.sigma);
  const auto dropped = filter.update().dropped;
  EXPECT_TRUE(std::any_of(dropped.begin(), dropped.end(),
                          [old](const auto& sight) { return sight.landmark == old; }));

  feed.add_next();
  for (int l = 0; l < filter.num_landmarks(); ++l)
    if (l != old) filter.remove_measurement(l, 30);
  const InformationFilter before = filter;
  EXPECT_EQ(filter.update().reason, Reason::kFilterFailed);
  for (int p = 0; p < before.num_poses(); ++p)
    EXPECT_EQ(filter.pose(p).translation, before.pose(p).translation) << p;
  for (int l = 0; l < before.num_landmarks(); ++l)
    EXPECT_EQ(filter.position(l), before.position(l)) << l;
}

}  // namespace
}  // namespace eifmap::test
