// Absolute measurements in the filter: what they make known, and how exactly.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "filter/derived_covariances.h"
#include "filter/information_filter.h"
#include "geometry/similarity.h"
#include "support/dense_system.h"
#include "support/filter_world.h"
#include "support/numeric_jacobian.h"

namespace eifmap::test {
namespace {

Eigen::Matrix3d isotropic(double sigma) {
  return sigma * sigma * Eigen::Matrix3d::Identity();
}

Rigid3 random_pose(Random& random, double size) {
  const Eigen::Vector3d turn = random.normal_vector<3>();
  return {so3_exp(turn), size * random.normal_vector<3>()};
}

// Of a measurement's residual, displaced by the error of one pose.
template <int M>
void expect_right_derivatives(const AbsoluteObservation& observation,
                              const std::vector<Rigid3>& poses, const Rigid3& earth_from_map) {
  const AbsoluteRows rows = linearize(observation, poses, earth_from_map);
  for (const PoseRows& of_pose : rows.of_pose) {
    const auto predicted = [&](const Eigen::Matrix<double, 6, 1>& delta) {
      std::vector<Rigid3> moved = poses;
      Rigid3 earth = earth_from_map;
      Rigid3& pose = of_pose.pose == kEarthFromMap ? earth : moved[of_pose.pose];
      pose = retract(pose, delta.head<3>(), delta.tail<3>());
      return Eigen::Matrix<double, M, 1>(
          -linearize(observation, moved, earth).residual.template head<M>());
    };
    const auto numeric = numeric_jacobian<M, 6>(predicted);
    EXPECT_LT(relative_difference(of_pose.derivative.topRows<M>(), numeric), 1e-7) << of_pose.pose;
    EXPECT_TRUE(of_pose.derivative.bottomRows(3 - M).isZero(0));
  }
}

TEST(AbsoluteObservation, HasTheDerivativesThatItSays) {
  Random random(3);
  std::vector<Rigid3> poses;
  for (int k = 0; k < 4; ++k) poses.push_back(random_pose(random, 3));
  const Rigid3 earth = random_pose(random, 50);
  const auto point = [&random](int pose) { return RigidPoint{pose, random.normal_vector<3>()}; };
  expect_right_derivatives<3>(
      AbsoluteObservation::position(point(2), random.normal_vector<3>(), isotropic(1)), poses,
      earth);
  // The way leaves pose 1, comes by it again with another point, and ends elsewhere.
  expect_right_derivatives<1>(
      AbsoluteObservation::length({point(1), point(0), point(1), point(3)}, 5, 0.1), poses, earth);
}

TEST(AbsoluteObservation, IsAsLongAsItsWay) {
  const std::vector<Rigid3> poses{{}, {{1, 0, 0, 0}, {3, 0, 0}}, {{1, 0, 0, 0}, {3, 4, 0}}};
  const auto way = AbsoluteObservation::length({{0}, {1}, {2}}, 10, 1);
  EXPECT_NEAR(linearize(way, poses, {}).residual.x(), 10 - 7, 1e-12);
  const auto distance = AbsoluteObservation::length({{0}, {2}}, 10, 1);
  EXPECT_NEAR(linearize(distance, poses, {}).residual.x(), 10 - 5, 1e-12);
}

// A world in metres whose map is in units of its own; the first baseline has the true length in
// them, so that `metres_per_unit` is what makes it metric.
class Absolute : public testing::Test {
 protected:
  static FilterWorldOptions options(std::uint64_t seed, int num_poses = 12) {
    FilterWorldOptions o;
    o.seed = seed;
    o.num_poses = num_poses;
    o.num_points = num_poses > 20 ? 4 * num_poses : 12 * num_poses;
    return o;
  }

  explicit Absolute() : Absolute(options(5)) {}
  explicit Absolute(const FilterWorldOptions& o, const FilterOptions& filter = {})
      : world_(make_filter_world(o, filter)) {
    world_.filter.update();
  }

  const Rigid3& truth(int pose) const { return world_.poses[pose]; }
  double true_distance(int i, int j) const {
    return kMetres * (truth(i).translation - truth(j).translation).norm();
  }
  Eigen::Vector3d true_position(int pose, const Eigen::Vector3d& lever = {0, 0, 0}) const {
    return earth_ *
           Eigen::Vector3d(kMetres * truth(pose).translation + truth(pose).rotation * lever);
  }
  // The truth in metres, to the filter.
  void add_positions(double sigma, int every, Random& random, int from = 0) {
    for (int p = from; p < world_.filter.num_poses(); p += every)
      EXPECT_EQ(world_.filter.add_absolute(AbsoluteObservation::position(
                    {p, lever_}, true_position(p, lever_) + sigma * random.normal_vector<3>(),
                    isotropic(sigma))),
                Reason::kNone)
          << p;
  }

  static constexpr double kMetres = 2.5;  // per unit
  Eigen::Vector3d lever_{0.3, -0.2, 0.1};
  Rigid3 earth_{so3_exp({0.4, -1.1, 2}), {500, -200, 30}};
  FilterWorld world_;
};

std::vector<double> all_errors(const InformationFilter& filter) {
  std::vector<double> errors;
  for (int l = 0; l < filter.num_landmarks(); ++l)
    for (const PointMeasurement& m : filter.landmark(l).measurements)
      errors.push_back(filter.error(l, m));
  return errors;
}

TEST_F(Absolute, BecomingMetricChangesNothingThatTheSightsSay) {
  const InformationFilter before = world_.filter;
  const std::vector<double> errors = all_errors(before);
  world_.filter.make_metric(kMetres);
  const std::vector<double> now = all_errors(world_.filter);
  ASSERT_EQ(errors.size(), now.size());
  for (std::size_t k = 0; k < errors.size(); ++k) EXPECT_NEAR(errors[k], now[k], 1e-10);
  for (int p = 0; p < before.num_poses(); ++p) {
    EXPECT_EQ(world_.filter.pose(p).translation, kMetres * before.pose(p).translation);
    EXPECT_EQ(world_.filter.pose(p).rotation.coeffs(), before.pose(p).rotation.coeffs());
  }
  for (int l = 0; l < before.num_landmarks(); ++l)
    EXPECT_EQ(world_.filter.position(l), kMetres * before.position(l));
}

// All of the information, the first pose counted too, and no gauge.
int deficiency(const InformationFilter& filter) {
  const int n = 6 * filter.num_poses();
  Eigen::MatrixXd information =
      Eigen::MatrixXd::Zero(n + 3 * filter.num_landmarks(), n + 3 * filter.num_landmarks());
  const auto add = [&information](const Eigen::MatrixXd& h) { information += h.transpose() * h; };
  for (int l = 0; l < filter.num_landmarks(); ++l)
    for (const PointMeasurement& m : filter.landmark(l).measurements) {
      Eigen::MatrixXd h = Eigen::MatrixXd::Zero(2, information.cols());
      h.middleCols<6>(6 * m.pose) = m.d_pose();
      h.middleCols<3>(n + 3 * l) = m.frozen.to_landmark;
      add(h);
    }
  for (const FilterAbsolute& absolute : filter.absolutes()) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3, information.cols());
    for (const PoseRows& rows : absolute.frozen.of_pose)
      h.middleCols<6>(6 * rows.pose) = rows.derivative;
    add(h);
  }
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd balanced = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(balanced).eigenvalues();
  return static_cast<int>((values.array() < 1e-11 * values.maxCoeff()).count());
}

// All linearized at one place, or the ways in which nothing changes would differ by measurement.
class AbsoluteRank : public Absolute {
 protected:
  static FilterOptions always() {
    FilterOptions o;
    o.relinearize = Relinearize::kAlways;
    o.gate_sigma = 1e9;
    o.max_iterations = 30;
    return o;
  }
  AbsoluteRank() : Absolute(options(5, 5), always()) {}
};

TEST_F(AbsoluteRank, OneKnownDistanceMakesItOneMore) {
  EXPECT_EQ(deficiency(world_.filter), 7);
  world_.filter.make_metric(kMetres);
  ASSERT_EQ(world_.filter.add_absolute(
                AbsoluteObservation::length({{1}, {4}}, true_distance(1, 4), 0.01), false),
            Reason::kNone);
  ASSERT_EQ(world_.filter.update().reason, Reason::kNone);
  EXPECT_EQ(deficiency(world_.filter), 6);
}

class AbsoluteFrozen : public Absolute {
 protected:
  static FilterOptions frozen() {
    FilterOptions o;
    o.relinearize = Relinearize::kOnce;
    o.gate_sigma = 1e9;
    return o;
  }
  AbsoluteFrozen() : Absolute(options(21, 7), frozen()) {}
};

TEST_F(AbsoluteFrozen, CovariancesAreThoseOfTheDenseInverse) {
  InformationFilter& filter = world_.filter;
  Random random(2);
  filter.make_metric(kMetres);
  filter.set_earth_from_map(retract(earth_, {0.01, 0, 0.01}, {0.1, 0.1, 0}));
  const auto position = [&](int p) {
    return AbsoluteObservation::position({p, lever_}, true_position(p, lever_), isotropic(0.1));
  };
  for (int p = 0; p < 7; ++p) ASSERT_EQ(filter.add_absolute(position(p), false), Reason::kNone);
  ASSERT_EQ(
      filter.add_absolute(AbsoluteObservation::length({{1}, {3, lever_}, {5}}, 3.1, 0.05), false),
      Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  // Another pose: its block comes after earth's.
  const int fresh = filter.add_pose(filter.pose(6));
  EXPECT_EQ(fresh, 7);
  for (int l = 0; l < filter.num_landmarks(); ++l) {
    Eigen::Vector2d x;
    if (project(filter.pose(6), filter.position(l), x)) filter.add_measurement(l, fresh, x, 2e-3);
  }
  ASSERT_EQ(filter.add_absolute(position(2), false), Reason::kNone);
  ASSERT_EQ(filter.update().reason, Reason::kNone);

  const Eigen::MatrixXd inverse = dense_covariance(filter, Eigen::Vector3d::UnitX());
  const auto block = [&](int p) {
    const int at = 6 * filter.blocks().of(p);
    return Eigen::Matrix<double, 6, 6>(inverse.block<6, 6>(at, at));
  };
  for (int p = 1; p < filter.num_poses(); ++p) {
    PoseBlock covariance;
    ASSERT_TRUE(filter.pose_covariance(p, covariance));
    EXPECT_LT((covariance - block(p)).norm(), 1e-8 * block(p).norm()) << p;
  }
  PoseBlock of_earth;
  ASSERT_TRUE(filter.propagate({{kEarthFromMap, PoseBlock::Identity()}}, of_earth));
  EXPECT_LT((of_earth - block(kEarthFromMap)).norm(), 1e-8 * of_earth.norm());
  const int n = 6 * filter.blocks().count(filter.num_poses());
  for (int l = 0; l < filter.num_landmarks(); l += 5) {
    Eigen::Matrix3d covariance;
    ASSERT_TRUE(filter.landmark_covariance(l, covariance));
    const Eigen::Matrix3d expected = inverse.block<3, 3>(n + 3 * l, n + 3 * l);
    EXPECT_LT((covariance - expected).norm(), 1e-8 * expected.norm()) << l;
  }
}

// More poses than settle by themselves, before and after earth_from_map came.
class AbsoluteLongWay : public Absolute {
 protected:
  static FilterOptions all_sights() {
    FilterOptions o;
    o.gate_sigma = 1e9;
    return o;
  }
  AbsoluteLongWay() : Absolute(options(9, 32), all_sights()) {}
};

TEST_F(AbsoluteLongWay, EndsAtTheLeastSquaresMean) {
  InformationFilter& filter = world_.filter;
  Random random(4);
  filter.make_metric(1.02 * kMetres);
  filter.set_earth_from_map(retract(earth_, {0.02, -0.03, 0.01}, {0.2, 0.1, -0.3}));
  for (int p = 0; p < 32; p += 3)
    ASSERT_EQ(filter.add_absolute(
                  AbsoluteObservation::position(
                      {p, lever_}, true_position(p, lever_) + 0.1 * random.normal_vector<3>(),
                      isotropic(0.1)),
                  false),
              Reason::kNone);
  for (int k = 0; k < 4; ++k) ASSERT_EQ(filter.update().reason, Reason::kNone);
  Dense dense = dense_system(filter);
  for (double& x : dense.information.diagonal())
    if (x == 0) x = 1;  // of a landmark that was dropped
  const Eigen::VectorXd step = dense.information.ldlt().solve(dense.right_side);
  EXPECT_LT(step.dot(dense.right_side), 1e-5);  // sigmas, squared
  for (int p = 0; p < 32; ++p)
    EXPECT_LT((kMetres * truth(p).translation - filter.pose(p).translation).norm(), 0.3) << p;
}

// Thirty poses straight ahead, then thirty to the side: until then nothing says how earth is turned
// about the first line.
TEST(AbsoluteStraight, StaysPositiveDefiniteAndTurnsWithTheWay) {
  constexpr double kSigma = 0.05;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    FilterWorldOptions o{.num_poses = 30, .num_points = 400, .step = {0.3, 0, 0}, .seed = seed};
    FilterWorld world = make_filter_world(o);
    InformationFilter& filter = world.filter;
    Random random(seed);
    ASSERT_EQ(filter.update().reason, Reason::kNone);
    const Rigid3 earth = random_pose(random, 100);
    filter.make_metric(1);
    // As far off as may be, about the line.
    filter.set_earth_from_map(earth * Rigid3(so3_exp({2.9, 0, 0}), {0, 0, 0}));
    const auto position = [&](int p) {
      return AbsoluteObservation::position(
          {p}, earth * world.poses[p].translation + kSigma * random.normal_vector<3>(),
          isotropic(kSigma));
    };
    for (int p = 0; p < 20; ++p) ASSERT_EQ(filter.add_absolute(position(p), false), Reason::kNone);
    ASSERT_EQ(filter.update().reason, Reason::kNone);
    PoseBlock covariance;
    ASSERT_TRUE(filter.propagate({{kEarthFromMap, PoseBlock::Identity()}}, covariance));
    // It knows that it does not know; the prior's half a radian is no certainty either.
    EXPECT_GT(std::sqrt(covariance(0, 0)), 0.1);
    // A point far beside the line, fixed to poses of it, shows how earth is turned.
    for (int p = 20; p < 30; ++p) {
      const RigidPoint beside{p, {0, 10, 3}};
      ASSERT_EQ(filter.add_absolute(AbsoluteObservation::position(
                    beside,
                    earth * (world.poses[p] * beside.in_pose) + kSigma * random.normal_vector<3>(),
                    isotropic(kSigma))),
                Reason::kNone)
          << "seed " << seed << " pose " << p;
      ASSERT_EQ(filter.update().reason, Reason::kNone);
    }
    const Eigen::Vector3d off =
        so3_log(earth.rotation.conjugate() * filter.earth_from_map().rotation);
    EXPECT_LT(off.norm(), 0.1) << "seed " << seed;
  }
}

TEST_F(Absolute, WhatContradictsTheMapIsRefused) {
  InformationFilter& filter = world_.filter;
  Random random(6);
  filter.make_metric(kMetres);
  filter.set_earth_from_map(earth_);
  for (int p = 0; p < 12; ++p)
    ASSERT_EQ(filter.add_absolute(AbsoluteObservation::position(
                                      {p, lever_}, true_position(p, lever_), isotropic(0.05)),
                                  false),
              Reason::kNone);
  filter.update();
  const auto off_by = [&](double metres) {
    return AbsoluteObservation::position(
        {7, lever_}, true_position(7, lever_) + Eigen::Vector3d(0, metres, 0), isotropic(0.05));
  };
  EXPECT_EQ(filter.add_absolute(off_by(3)), Reason::kMeasurementGated);
  EXPECT_EQ(filter.add_absolute(off_by(0.01)), Reason::kNone);
  const double distance = true_distance(2, 9);
  EXPECT_EQ(filter.add_absolute(AbsoluteObservation::length({{2}, {9}}, 1.5 * distance, 0.01)),
            Reason::kMeasurementGated);
  EXPECT_EQ(filter.add_absolute(AbsoluteObservation::length({{2}, {9}}, distance, 0.05)),
            Reason::kNone);
  EXPECT_EQ(filter.absolutes().size(), 14u);
}

TEST_F(Absolute, BadNumbersAreRefused) {
  InformationFilter& filter = world_.filter;
  const double nan = std::nan("");
  const auto length = [](double metres, double sigma) {
    return AbsoluteObservation::length({{1}, {4}}, metres, sigma);
  };
  EXPECT_THROW(filter.add_absolute(length(1, 1)), std::invalid_argument);
  EXPECT_THROW(filter.set_earth_from_map({}), std::invalid_argument);
  EXPECT_THROW(filter.make_metric(0), std::invalid_argument);
  EXPECT_THROW(filter.make_metric(nan), std::invalid_argument);
  filter.make_metric(kMetres);
  EXPECT_THROW(filter.make_metric(kMetres), std::invalid_argument);
  EXPECT_EQ(filter.add_absolute(length(nan, 1)), Reason::kBadMeasurement);
  EXPECT_EQ(filter.add_absolute(length(1, 0)), Reason::kBadMeasurementCovariance);
  EXPECT_EQ(filter.add_absolute(length(1, nan)), Reason::kBadMeasurementCovariance);
  EXPECT_EQ(filter.add_absolute(AbsoluteObservation::length({{1}}, 1, 1)), Reason::kBadMeasurement);
  EXPECT_EQ(filter.add_absolute(AbsoluteObservation::length(
                std::vector<RigidPoint>(kMostPoints + 1, RigidPoint{1}), 1, 1)),
            Reason::kMeasurementTooLong);
  EXPECT_EQ(filter.add_absolute(AbsoluteObservation::length({{3}, {3, {1, 0, 0}}}, 1, 1)),
            Reason::kMeasurementWithoutBaseline);
  EXPECT_THROW(filter.add_absolute(AbsoluteObservation::length({{1}, {99}}, 1, 1)),
               std::invalid_argument);
  const auto position = [](const Eigen::Matrix3d& covariance) {
    return AbsoluteObservation::position({3}, {1, 2, 3}, covariance);
  };
  EXPECT_EQ(filter.add_absolute(position(isotropic(1))), Reason::kMeasurementWithoutPose);
  filter.set_earth_from_map({});
  EXPECT_EQ(filter.add_absolute(position(-isotropic(1))), Reason::kBadMeasurementCovariance);
  EXPECT_EQ(filter.add_absolute(position(nan * isotropic(1))), Reason::kBadMeasurementCovariance);
  EXPECT_TRUE(filter.absolutes().empty());
}

// The scale by a known distance, over seeds: what log_scale_variance() says is what the error is.
TEST(AbsoluteScale, IsAsUncertainAsTheFilterSays) {
  constexpr int kSeeds = 60;
  constexpr double kMetres = 2.5;
  double nees = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    FilterWorld world = make_filter_world({.seed = seed});
    InformationFilter& filter = world.filter;
    Random random(1000 + seed);
    ASSERT_EQ(filter.update().reason, Reason::kNone);
    const double distance =
        kMetres * (world.poses[2].translation - world.poses[8].translation).norm();
    const double sigma = 0.02 * distance, measured = distance + sigma * random.normal();
    const double in_map = (filter.pose(2).translation - filter.pose(8).translation).norm();
    filter.make_metric(measured / in_map);
    ASSERT_EQ(filter.add_absolute(AbsoluteObservation::length({{2}, {8}}, measured, sigma), false),
              Reason::kNone);
    ASSERT_EQ(filter.update().reason, Reason::kNone);
    Eigen::Matrix3Xd truth(3, filter.num_poses()), estimate = truth;
    std::vector<int> all;
    for (int p = 0; p < filter.num_poses(); ++p) {
      truth.col(p) = kMetres * world.poses[p].translation;
      estimate.col(p) = filter.pose(p).translation;
      all.push_back(p);
    }
    double variance = 0;
    ASSERT_TRUE(log_scale_variance(filter, all, variance));
    const double said = std::sqrt(variance);
    EXPECT_GT(said, 0.019);
    nees += std::pow(std::log(fit_similarity(truth, estimate).scale) / said, 2) / kSeeds;
  }
  // 95 % of chi-square(60) / 60 is within these.
  EXPECT_GT(nees, 0.675);
  EXPECT_LT(nees, 1.388);
}

// Where measurements are noisier than the map, a single one asks for any variance of it.
TEST(AbsoluteVariance, NoisyPositionsDoNotMakeARightMapBelievedLess) {
  constexpr int kWorlds = 12, kFirst = 4;
  constexpr double kSigma = 0.3;
  int raised = 0;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    FilterWorld world = make_filter_world({.num_poses = 30, .num_points = 150, .seed = seed});
    Random random(seed + 100);
    InformationFilter& filter = world.filter;
    filter.update();
    filter.make_metric(1);
    filter.set_earth_from_map({});
    for (int p = 0; p < filter.num_poses(); ++p) {
      const Eigen::Vector3d position =
          world.poses[p].translation + kSigma * random.normal_vector<3>();
      filter.add_absolute(AbsoluteObservation::position({p}, position, isotropic(kSigma)),
                          p >= kFirst);
      if (p >= kFirst - 1) {
        ASSERT_EQ(filter.update().reason, Reason::kNone);
      }
    }
    raised += filter.map_variance() > 1.2 ? 1 : 0;
  }
  EXPECT_LE(raised, 1);
}

}  // namespace
}  // namespace eifmap::test
