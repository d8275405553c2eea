// Which way is down, in the filter: it levels the map, and holds it level.
#include <gtest/gtest.h>

#include <cmath>

#include "filter/derived_covariances.h"
#include "filter/information_filter.h"
#include "support/dense_system.h"
#include "support/filter_world.h"
#include "support/numeric_jacobian.h"

namespace eifmap::test {
namespace {

using Kind = AbsoluteObservation::Kind;

Eigen::Matrix3d isotropic(double sigma) {
  return sigma * sigma * Eigen::Matrix3d::Identity();
}

const Eigen::Quaterniond kTrueEarth = so3_exp({0.4, -1.1, 2});

// Measured by a camera, turned by `off` (rad, its frame).
Eigen::Vector3d down_in(const Rigid3& camera, const Eigen::Vector3d& off = {0, 0, 0}) {
  const Eigen::Vector3d in_map = kTrueEarth.conjugate() * Eigen::Vector3d(0, 0, -1);
  return so3_exp(off) * (camera.rotation.conjugate() * in_map);
}

// Of the map, as it is told from how it is.
Eigen::Vector2d tilt_off(const InformationFilter& filter) {
  const Eigen::Vector3d up =
      filter.earth_from_map().rotation * (kTrueEarth.conjugate() * Eigen::Vector3d::UnitZ());
  return {-up.y(), up.x()};  // what turns z into it
}

struct Levelled {
  explicit Levelled(std::uint64_t seed, double sigma = 0.01, double start_off = 0.05,
                    const FilterWorldOptions& options = {})
      : world([&] {
          FilterWorldOptions o = options;
          o.seed = seed;
          return make_filter_world(o);
        }()),
        random(seed + 500) {
    world.filter.update();
    world.filter.set_level(so3_exp({start_off, -start_off, 0}) * kTrueEarth);
    for (int p = 0; p < world.filter.num_poses(); ++p)
      EXPECT_EQ(add(p, sigma, sigma * random.normal_vector<3>()), Reason::kNone);
    EXPECT_EQ(world.filter.update().reason, Reason::kNone);
  }
  Reason add(int pose, double sigma, const Eigen::Vector3d& off, bool gated = false) {
    return world.filter.add_absolute(
        AbsoluteObservation::down(pose, 9.81 * down_in(world.poses[pose], off), isotropic(sigma)),
        gated);
  }

  FilterWorld world;
  Random random;
};

TEST(Down, HasTheDerivativesThatItSays) {
  Random random(8);
  for (int k = 0; k < 20; ++k) {
    const std::vector<Rigid3> poses{
        {}, {so3_exp(random.normal_vector<3>()), random.normal_vector<3>()}};
    const Rigid3 earth{so3_exp(random.normal_vector<3>()), random.normal_vector<3>()};
    const Eigen::Vector3d true_down =
        poses[1].rotation.conjugate() * (earth.rotation.conjugate() * Eigen::Vector3d(0, 0, -1));
    const auto observation = AbsoluteObservation::down(
        1, so3_exp(0.03 * k * random.normal_vector<3>()) * true_down, isotropic(1));
    if (observation.value.dot(true_down) < 0.3) continue;
    const AbsoluteRows rows = linearize(observation, poses, earth);
    EXPECT_NEAR(rows.residual.norm(), std::acos(std::min(1.0, observation.value.dot(true_down))),
                1e-7);
    EXPECT_EQ(rows.residual.z(), 0);
    for (const PoseRows& of_pose : rows.of_pose) {
      const auto predicted = [&](const Eigen::Matrix<double, 6, 1>& delta) {
        std::vector<Rigid3> moved = poses;
        Rigid3 moved_earth = earth;
        Rigid3& pose = of_pose.pose == kEarthFromMap ? moved_earth : moved[1];
        pose = retract(pose, delta.head<3>(), delta.tail<3>());
        return Eigen::Vector2d(-linearize(observation, moved, moved_earth).residual.head<2>());
      };
      const auto numeric = numeric_jacobian<2, 6>(predicted);
      EXPECT_LT(relative_difference(of_pose.derivative.topRows<2>(), numeric), 1e-6) << k;
      EXPECT_TRUE(of_pose.derivative.row(2).isZero(0));
    }
  }
}

TEST(Down, UpsideDownIsAsWrongAsCanBe) {
  for (const Eigen::Vector3d& off : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1e-6, 0, 1)}) {
    const auto observation = AbsoluteObservation::down(0, off, isotropic(1));
    EXPECT_NEAR(linearize(observation, {Rigid3()}, {}).residual.norm(), EIGEN_PI, 1e-5);
  }
}

TEST(Gravity, LevelsAMapWithoutScale) {
  constexpr int kSeeds = 40;
  double nees = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Levelled levelled(seed);
    const InformationFilter& filter = levelled.world.filter;
    EXPECT_FALSE(filter.is_metric());
    EXPECT_FALSE(filter.has_earth());
    ASSERT_TRUE(filter.has_level());
    // What it does not tell stays where it was.
    EXPECT_LT(filter.earth_from_map().translation.norm(), 1e-6);
    const Eigen::Quaterniond start = so3_exp({0.05, -0.05, 0}) * kTrueEarth;
    EXPECT_LT(
        std::abs(
            so3_log(start.conjugate() * filter.earth_from_map().rotation).dot(filter.held_up())),
        1e-3);
    const Eigen::Vector2d off = tilt_off(filter);
    EXPECT_LT(off.norm(), 0.03);
    PoseBlock covariance;
    ASSERT_TRUE(filter.propagate({{kEarthFromMap, PoseBlock::Identity()}}, covariance));
    const Eigen::Matrix3d turn = filter.earth_from_map().matrix();
    const Eigen::Matrix3d in_earth = turn * covariance.topLeftCorner<3, 3>() * turn.transpose();
    nees += off.dot(in_earth.topLeftCorner<2, 2>().ldlt().solve(off)) / kSeeds;
  }
  // 99 % of chi-square(80) / 40 is within these.
  EXPECT_GT(nees, 1.28);
  EXPECT_LT(nees, 2.91);
}

// A wrongly turned keyframe, far along a way, is told by its own down, and is as wrong as is said.
TEST(Gravity, KeepsALongWayLevel) {
  constexpr int kSeeds = 12;
  FilterWorldOptions way;
  way.num_poses = 60;
  way.num_points = 240;
  way.noise_px = 2;
  double with = 0, without = 0, said = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Levelled levelled(seed, 0.002, 0.01, way);
    way.seed = seed;
    FilterWorld bare = make_filter_world(way);
    bare.filter.update();
    const auto tilt = [&](const InformationFilter& filter, const Eigen::Quaterniond& earth) {
      const int last = filter.num_poses() - 1;
      const Eigen::Vector3d down =
          filter.pose(last).rotation.conjugate() * (earth.conjugate() * Eigen::Vector3d(0, 0, -1));
      return down.cross(down_in(levelled.world.poses[last])).squaredNorm();
    };
    with += tilt(levelled.world.filter, levelled.world.filter.earth_from_map().rotation);
    without += tilt(bare.filter, kTrueEarth);
    PoseBlock covariance;
    ASSERT_TRUE(covariance_in_earth(levelled.world.filter, way.num_poses - 1, covariance));
    said += covariance.topLeftCorner<3, 3>().trace();  // its turn about up among it
  }
  EXPECT_LT(std::sqrt(with), 0.5 * std::sqrt(without));
  EXPECT_LT(std::sqrt(with), 1.5 * std::sqrt(said));
}

TEST(Gravity, CovariancesAreThoseOfTheDenseInverse) {
  for (const bool with_positions : {false, true}) {
    Levelled levelled(3);
    InformationFilter& filter = levelled.world.filter;
    if (with_positions) {
      filter.make_metric(1);
      const Rigid3 earth{kTrueEarth, {5, 6, 7}};
      filter.set_earth_from_map(earth);
      EXPECT_TRUE(filter.held_up().isZero(0));
      for (int p = 0; p < filter.num_poses(); p += 2)
        ASSERT_EQ(filter.add_absolute(
                      AbsoluteObservation::position(p, earth * levelled.world.poses[p].translation,
                                                    isotropic(0.05)),
                      false),
                  Reason::kNone);
      ASSERT_EQ(filter.update().reason, Reason::kNone);
    }
    const Eigen::Vector3d baseline = levelled.world.poses[1].translation;
    const Eigen::MatrixXd dense = dense_covariance(filter, baseline);
    const int earth = filter.blocks().earth();
    PoseBlock of_earth;
    ASSERT_TRUE(filter.propagate({{kEarthFromMap, PoseBlock::Identity()}}, of_earth));
    const PoseBlock oracle = dense.block<6, 6>(6 * earth, 6 * earth);
    EXPECT_LT((of_earth - oracle).norm(), 1e-8 * oracle.norm()) << with_positions;
    for (int p = 2; p < filter.num_poses(); p += 3) {
      PoseBlock of_pose;
      ASSERT_TRUE(filter.pose_covariance(p, of_pose));
      const int b = filter.blocks().of(p);
      EXPECT_LT((of_pose - dense.block<6, 6>(6 * b, 6 * b)).norm(), 1e-8 * of_pose.norm()) << p;
    }
  }
}

TEST(Gravity, WhatContradictsTheMapIsRefused) {
  Levelled levelled(4);
  EXPECT_EQ(levelled.add(7, 0.01, {0.004, -0.01, 0}, true), Reason::kNone);
  EXPECT_EQ(levelled.add(8, 0.01, {0, 0.2, 0.1}, true), Reason::kMeasurementGated);
  const InformationFilter& filter = levelled.world.filter;
  const auto upside_down =
      AbsoluteObservation::down(5, -down_in(levelled.world.poses[5]), isotropic(0.01));
  EXPECT_EQ(levelled.world.filter.add_absolute(upside_down), Reason::kMeasurementGated);
  EXPECT_EQ(filter.absolutes().size(), 13u);
}

TEST(Gravity, NeedsALevelAndGoodNumbers) {
  FilterWorld world = make_filter_world({});
  InformationFilter& filter = world.filter;
  const auto down = [](const Eigen::Vector3d& direction, double sigma) {
    return AbsoluteObservation::down(3, direction, isotropic(sigma));
  };
  filter.update();
  EXPECT_EQ(filter.add_absolute(down({0, 1, 0}, 0.1)), Reason::kMeasurementWithoutPose);
  filter.set_level(Eigen::Quaterniond::Identity());
  EXPECT_THROW(filter.set_level(Eigen::Quaterniond::Identity()), std::invalid_argument);
  EXPECT_EQ(filter.add_absolute(down({0, std::nan(""), 0}, 0.1)), Reason::kBadMeasurement);
  EXPECT_EQ(filter.add_absolute(down({0, 1, 0}, 0)), Reason::kBadMeasurementCovariance);
  // A level is no place.
  filter.make_metric(1);
  EXPECT_EQ(filter.add_absolute(AbsoluteObservation::position(3, {0, 0, 0}, isotropic(1))),
            Reason::kMeasurementWithoutPose);
}

TEST(Gravity, GoesWithItsKeyframe) {
  Levelled levelled(6);
  InformationFilter& filter = levelled.world.filter;
  EXPECT_TRUE(filter.has_absolute(5, Kind::kDown));
  filter.remove_pose(5);
  EXPECT_FALSE(filter.has_absolute(5, Kind::kDown));
  EXPECT_EQ(filter.absolutes().size(), 11u);
  ASSERT_EQ(filter.update().reason, Reason::kNone);
  EXPECT_LT(tilt_off(filter).norm(), 0.03);
}

}  // namespace
}  // namespace eifmap::test
