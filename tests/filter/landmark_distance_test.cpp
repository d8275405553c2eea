// The distance of two landmarks as a measurement.
#include "filter/landmark_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "filter/derived_covariances.h"
#include "filter/information_filter.h"
#include "geometry/similarity.h"
#include "support/dense_system.h"
#include "support/filter_world.h"
#include "support/numeric_jacobian.h"

namespace eifmap::test {
namespace {

// Two that are seen often, and far from each other: the n-th such pair.
std::array<int, 2> a_pair(const InformationFilter& filter, int n = 0) {
  std::vector<int> seen;
  for (int l = 0; l < filter.num_landmarks(); ++l)
    if (filter.landmark(l).measurements.size() >= 6) seen.push_back(l);
  const auto half = static_cast<int>(seen.size()) / 2;
  return {seen.at(n), seen.at(half + n)};
}

// A metric world, its truth in the same unit.
struct Measured {
  explicit Measured(std::uint64_t seed)
      : world([&] {
          FilterWorldOptions o;
          o.seed = seed;
          return make_filter_world(o);
        }()) {
    EXPECT_EQ(world.filter.update().reason, Reason::kNone);
    world.filter.make_metric(1);
  }
  double true_distance(int a, int b) const {
    return (world.points[world.point_of[a]] - world.points[world.point_of[b]]).norm();
  }
  Reason add(int a, int b, double metres, double sigma, bool gated = false) {
    return world.filter.add_absolute(AbsoluteObservation::distance(a, b, metres, sigma), gated);
  }

  FilterWorld world;
};

// Seen just where it is: then the derivative of Gauss and Newton is that of the best place.
FilterLandmark without_residuals(const InformationFilter& filter, int landmark) {
  FilterLandmark exact = filter.landmark(landmark);
  for (PointMeasurement& m : exact.measurements)
    EXPECT_TRUE(project(filter.pose(m.pose), exact.position, m.x));
  return exact;
}

// The landmark's best place while the poses are these.
Eigen::Vector3d best_place(const FilterLandmark& landmark, const std::vector<Rigid3>& poses) {
  Eigen::Vector3d place = landmark.position;
  for (int k = 0; k < 10; ++k) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const PointMeasurement& m : landmark.measurements) {
      Eigen::Vector2d predicted = Eigen::Vector2d::Zero();
      Eigen::Matrix<double, 2, 3> to_point = Eigen::Matrix<double, 2, 3>::Zero();
      EXPECT_TRUE(Projector(poses[m.pose])(place, predicted, nullptr, &to_point));
      information += m.scale * m.scale * to_point.transpose() * to_point;
      gradient += m.scale * m.scale * to_point.transpose() * (m.x - predicted);
    }
    place += information.ldlt().solve(gradient);
  }
  return place;
}

TEST(LandmarkDistance, HasTheDerivativesThatItSays) {
  const Measured measured(1);
  const InformationFilter& filter = measured.world.filter;
  const auto [a, b] = a_pair(filter);
  const FilterLandmark one = without_residuals(filter, a), other = without_residuals(filter, b);
  const DistanceRows distance = linearize_distance(one, other, 5);
  EXPECT_NEAR(5 - distance.rows.residual.x(), (filter.position(a) - filter.position(b)).norm(),
              1e-12);
  std::vector<Rigid3> poses;
  for (int p = 0; p < filter.num_poses(); ++p) poses.push_back(filter.pose(p));
  ASSERT_GT(distance.rows.of_pose.size(), 6u);
  for (const PoseRows& rows : distance.rows.of_pose) {
    const auto predicted = [&](const Eigen::Matrix<double, 6, 1>& delta) {
      std::vector<Rigid3> moved = poses;
      moved[rows.pose] = retract(moved[rows.pose], delta.head<3>(), delta.tail<3>());
      return Eigen::Matrix<double, 1, 1>(
          (best_place(one, moved) - best_place(other, moved)).norm());
    };
    const auto numeric = numeric_jacobian<1, 6>(predicted);
    EXPECT_LT(relative_difference(rows.derivative.topRows<1>(), numeric), 1e-4) << rows.pose;
  }
}

// For the poses it is what a measurement between two features is in the matrix of everything.
TEST(LandmarkDistance, IsExactForThePoses) {
  Measured measured(2);
  InformationFilter& filter = measured.world.filter;
  const auto [a, b] = a_pair(filter);
  constexpr double kSigma = 0.02;
  ASSERT_EQ(measured.add(a, b, measured.true_distance(a, b), kSigma), Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  const Eigen::RowVector3d along =
      (filter.position(b) - filter.position(a)).normalized().transpose();
  // All but that one.
  Dense dense = dense_system(filter);
  Eigen::RowVectorXd h = Eigen::RowVectorXd::Zero(dense.information.cols());
  const FilterAbsolute& absolute = filter.absolutes().front();
  for (const PoseRows& rows : absolute.frozen.of_pose)
    if (rows.pose != 0) h.segment<6>(6 * filter.blocks().of(rows.pose)) = rows.derivative.row(0);
  dense.information -= h.transpose() * h;
  // And it as one of features.
  h.setZero();
  h.segment<3>(dense.pose_size + 3 * a) = -along;
  h.segment<3>(dense.pose_size + 3 * b) = along;
  dense.information += filter.absolute_weight() / (kSigma * kSigma) * h.transpose() * h;
  const Eigen::MatrixXd all =
      filter.variance() * dense.information.ldlt().solve(Eigen::MatrixXd::Identity(
                              dense.information.rows(), dense.information.cols()));
  for (int p = 1; p < filter.num_poses(); ++p) {
    PoseBlock of_pose;
    ASSERT_TRUE(filter.pose_covariance(p, of_pose));
    const int at = 6 * filter.blocks().of(p);
    EXPECT_LT((of_pose - all.block<6, 6>(at, at)).norm(), 2e-3 * of_pose.norm()) << p;
  }
}

// One, or all three of a triangle, whose corners' errors are in two of them each.
TEST(LandmarkDistance, FixesTheScaleAsSurelyAsIsSaid) {
  constexpr int kSeeds = 40;
  constexpr double kSigma = 0.05;
  for (const bool triangle : {false, true}) {
    double nees = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      FilterWorldOptions o;
      o.seed = seed;
      FilterWorld bare = make_filter_world(o);
      ASSERT_EQ(bare.filter.update().reason, Reason::kNone);
      Measured measured(seed);
      InformationFilter& filter = measured.world.filter;
      Random random(seed + 900);
      const auto [a, b] = a_pair(filter);
      const int c = a_pair(filter, 3)[1];
      const auto measure = [&](int one, int other) {
        return measured.add(one, other,
                            measured.true_distance(one, other) + kSigma * random.normal(), kSigma);
      };
      ASSERT_EQ(measure(a, b), Reason::kNone);
      if (triangle) {
        ASSERT_EQ(measure(b, c), Reason::kNone);
        ASSERT_EQ(measure(c, a), Reason::kNone);
      }
      ASSERT_EQ(filter.update().reason, Reason::kNone);
      Eigen::Matrix3Xd truth(3, filter.num_poses()), estimate = truth;
      std::vector<int> all;
      for (int p = 0; p < filter.num_poses(); ++p) {
        truth.col(p) = measured.world.poses[p].translation;
        estimate.col(p) = filter.pose(p).translation;
        all.push_back(p);
      }
      double variance = 0;
      ASSERT_TRUE(log_scale_variance(filter, all, variance));
      nees += std::pow(std::log(fit_similarity(truth, estimate).scale), 2) / variance / kSeeds;
    }
    // 99 % of chi-square(40) / 40 is within these; of a triangle less is said than is known.
    EXPECT_GT(nees, triangle ? 0.3 : 0.51) << triangle;
    EXPECT_LT(nees, 1.67) << triangle;
  }
}

TEST(LandmarkDistance, HoldsItsLength) {
  Measured measured(3);
  InformationFilter& filter = measured.world.filter;
  const auto [a, b] = a_pair(filter);
  const double metres = 1.02 * (filter.position(a) - filter.position(b)).norm();
  ASSERT_EQ(measured.add(a, b, metres, 1e-4), Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  // The map as a whole grows: little of it is what its landmarks' own sights leave open.
  EXPECT_NEAR((filter.position(a) - filter.position(b)).norm(), metres, 0.003 * metres);
  EXPECT_GT((filter.pose(11).translation - filter.pose(0).translation).norm(),
            1.01 * (measured.world.poses[11].translation).norm());
}

TEST(LandmarkDistance, FollowsWhatItsLandmarksAreSeenFrom) {
  Measured measured(4);
  InformationFilter& filter = measured.world.filter;
  const auto [a, b] = a_pair(filter);
  const auto [c, d] = a_pair(filter, 2);
  ASSERT_EQ(measured.add(a, b, measured.true_distance(a, b), 0.05), Reason::kNone);
  ASSERT_EQ(measured.add(c, d, measured.true_distance(c, d), 0.05), Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  const auto expect_the_dense = [&](const char* when) {
    const Eigen::MatrixXd dense = dense_covariance(filter, Eigen::Vector3d::UnitX());
    for (int p = 1; p < filter.num_poses(); ++p) {
      if (filter.is_removed(p)) continue;
      PoseBlock of_pose;
      ASSERT_TRUE(filter.pose_covariance(p, of_pose)) << when;
      const int at = 6 * filter.blocks().of(p);
      EXPECT_LT((of_pose - dense.block<6, 6>(at, at)).norm(), 1e-7 * of_pose.norm()) << when << p;
    }
  };
  expect_the_dense("as added ");
  const int from = filter.landmark(a).measurements[2].pose;
  filter.remove_measurement(a, from);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  for (const PoseRows& rows : filter.absolutes().front().frozen.of_pose) {
    EXPECT_TRUE(rows.pose != from ||
                std::any_of(filter.landmark(b).measurements.begin(),
                            filter.landmark(b).measurements.end(),
                            [from](const PointMeasurement& m) { return m.pose == from; }));
  }
  expect_the_dense("without a sight ");
  const int gone = filter.landmark(c).measurements.back().pose;
  filter.remove_pose(gone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  EXPECT_EQ(filter.absolutes().size(), 2u);
  for (const FilterAbsolute& absolute : filter.absolutes())
    for (const PoseRows& rows : absolute.frozen.of_pose) EXPECT_NE(rows.pose, gone);
  filter.remove_landmark(c);
  EXPECT_EQ(filter.absolutes().size(), 1u);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  filter.remove_landmark(b);
  EXPECT_TRUE(filter.absolutes().empty());
}

// The scale may rest on it: sights that do not fit cost another landmark, not a measured one.
TEST(LandmarkDistance, IsNotLostWithSightsThatDoNotFit) {
  Measured measured(6);
  InformationFilter& filter = measured.world.filter;
  const auto [a, b] = a_pair(filter);
  const int other = a_pair(filter, 1)[0];
  ASSERT_EQ(measured.add(a, b, measured.true_distance(a, b), 0.05), Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  // Two sights are left to each, which no place explains.
  for (const int landmark : {a, other}) {
    const std::vector<PointMeasurement> sights = filter.landmark(landmark).measurements;
    for (std::size_t k = 2; k < sights.size(); ++k)
      filter.remove_measurement(landmark, sights[k].pose);
    for (std::size_t k = 0; k < 2; ++k) {
      const Eigen::Vector2d off(0, k == 0 ? 0.1 : -0.1);
      filter.remove_measurement(landmark, sights[k].pose);
      filter.add_measurement(landmark, sights[k].pose, sights[k].x + off, sights[k].sigma);
    }
  }
  filter.update();
  EXPECT_LT(filter.landmark(other).measurements.size(), 2u) << "else this shows nothing";
  EXPECT_EQ(filter.landmark(a).measurements.size(), 2u);
  EXPECT_EQ(filter.absolutes().size(), 1u);
}

TEST(LandmarkDistance, WhatIsWrongIsRefused) {
  Measured measured(5);
  InformationFilter& filter = measured.world.filter;
  const auto [a, b] = a_pair(filter);
  const double metres = measured.true_distance(a, b);
  ASSERT_EQ(measured.add(a, b, metres, 0.01), Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  const auto [c, d] = a_pair(filter, 1);
  EXPECT_EQ(measured.add(c, d, 1.5 * measured.true_distance(c, d), 0.01, true),
            Reason::kMeasurementGated);
  EXPECT_EQ(measured.add(c, d, measured.true_distance(c, d), 0.02, true), Reason::kNone);
  EXPECT_EQ(measured.add(a, a, 1, 0.02), Reason::kMeasurementWithoutBaseline);
  EXPECT_EQ(measured.add(a, b, metres, 0), Reason::kBadMeasurementCovariance);
  EXPECT_EQ(measured.add(a, b, std::nan(""), 1), Reason::kBadMeasurement);
  EXPECT_THROW(measured.add(a, filter.num_landmarks(), 1, 1), std::invalid_argument);
  filter.remove_landmark(d);
  EXPECT_EQ(measured.add(a, d, 1, 1), Reason::kMeasurementWithoutLandmark);
}

}  // namespace
}  // namespace eifmap::test
