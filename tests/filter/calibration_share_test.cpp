// What a calibration that is off does to the scale, against maps that are made with it.
#include "filter/calibration_share.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/filter_world.h"

namespace eifmap::test {
namespace {

constexpr double kFocal = 0.004, kCentre = 0.002, kRadial = 0.003;

// A map of sights without noise, with one known distance at its beginning, after some distortion of
// its sights.
template <class Distort>
InformationFilter map_of(const Distort& distort) {
  FilterOptions options;
  options.relinearize = Relinearize::kAlways;
  options.gate_sigma = 1e9;
  options.huber_sigma = 1e9;
  options.max_iterations = 30;
  FilterWorldOptions o{
      .num_poses = 16, .num_points = 200, .noise_px = 1e-6, .start_error = 0.001, .seed = 4};
  o.step = {0.1, 0.02, 0.4};
  const FilterWorld world = make_filter_world(o, options);
  InformationFilter filter(options, o.pixel);
  for (const Rigid3& pose : world.poses) filter.add_pose(pose);
  for (int l = 0; l < world.filter.num_landmarks(); ++l) {
    filter.add_landmark(world.filter.position(l), Eigen::Matrix3d::Zero());
    for (const PointMeasurement& m : world.filter.landmark(l).measurements)
      filter.add_measurement(l, m.pose, distort(m.x), 2e-3);
  }
  filter.update();
  filter.make_metric(1);
  filter.add_absolute(
      AbsoluteObservation::length(
          {{0}, {3}}, (world.poses[3].translation - world.poses[0].translation).norm(), 1e-6),
      false);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(filter.update().reason, Reason::kNone);
  return filter;
}

const std::vector<int> kLatest{12, 13, 14, 15};

// By which the latest poses' way differs from that of the undistorted map.
double log_scale(const InformationFilter& filter, const InformationFilter& straight) {
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  for (const int p : kLatest)
    a += filter.pose(p).translation / 4, b += straight.pose(p).translation / 4;
  double along = 0, squared = 0;
  for (const int p : kLatest) {
    along += (straight.pose(p).translation - b).dot(filter.pose(p).translation - a);
    squared += (straight.pose(p).translation - b).squaredNorm();
  }
  return along / squared - 1;
}

TEST(CalibrationShare, IsWhatAMapMadeWithItDriftsBy) {
  const InformationFilter straight = map_of([](const Eigen::Vector2d& x) { return x; });
  const auto expect_share = [&](const CalibrationSigmas& sigmas, double drift) {
    constexpr double kNothing = 1e-6;
    double variance = 0;
    ASSERT_TRUE(CalibrationShare(straight, sigmas).variance(kLatest, variance));
    EXPECT_NEAR(std::sqrt(variance), std::abs(drift), 0.1 * std::abs(drift) + kNothing);
  };
  const auto drift = [&](const auto& distort) { return log_scale(map_of(distort), straight); };
  // A straight way keeps its scale whatever the focal length.
  expect_share({kFocal, 0, 0},
               drift([](const Eigen::Vector2d& x) { return Eigen::Vector2d((1 - kFocal) * x); }));
  const double radial = drift([](const Eigen::Vector2d& x) {
    return Eigen::Vector2d((1 - kRadial * x.squaredNorm()) * x);
  });
  expect_share({0, 0, kRadial}, radial);
  const double right = drift(
      [](const Eigen::Vector2d& x) { return Eigen::Vector2d(x - Eigen::Vector2d(kCentre, 0)); });
  const double down = drift(
      [](const Eigen::Vector2d& x) { return Eigen::Vector2d(x - Eigen::Vector2d(0, kCentre)); });
  expect_share({0, kCentre, 0}, std::hypot(right, down));
  EXPECT_GT(std::abs(radial), 5e-5) << "else this shows little";
  EXPECT_GT(std::hypot(right, down), 5e-5) << "else this shows little";
}

TEST(CalibrationShare, OfNoUncertaintyIsNone) {
  const InformationFilter straight = map_of([](const Eigen::Vector2d& x) { return x; });
  double variance = 1;
  ASSERT_TRUE(CalibrationShare(straight, {}).variance(kLatest, variance));
  EXPECT_EQ(variance, 0);
  EXPECT_FALSE(CalibrationShare(straight, {}).variance({3}, variance));
}

}  // namespace
}  // namespace eifmap::test
