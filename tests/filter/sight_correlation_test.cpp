#include "filter/sight_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "geometry/projection.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

// Tracks of `length` sights whose errors follow a first-order autoregression; each point is where
// its sights have it on average, as an estimate would be.
SightCorrelation measured(double rho, int length, int tracks) {
  Random random(static_cast<std::uint64_t>(100 * rho) + 7);
  std::vector<Rigid3> poses;
  for (int p = 0; p < length; ++p) poses.push_back(Rigid3({1, 0, 0, 0}, {0.05 * p, 0, 0}));
  std::vector<FilterLandmark> landmarks;
  constexpr double kSigma = 1e-3;
  for (int t = 0; t < tracks; ++t) {
    FilterLandmark landmark;
    landmark.position = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(4, 6)};
    Eigen::Vector2d error = random.normal_vector<2>(), mean = Eigen::Vector2d::Zero();
    for (int p = 0; p < length; ++p) {
      PointMeasurement m;
      m.pose = p;
      m.sigma = kSigma;
      EXPECT_TRUE(project(poses[static_cast<std::size_t>(p)], landmark.position, m.x));
      m.x += kSigma * error;
      mean += error / length;
      landmark.measurements.push_back(m);
      error = rho * error + std::sqrt(1 - rho * rho) * random.normal_vector<2>();
    }
    for (PointMeasurement& m : landmark.measurements) m.x -= kSigma * mean;
    // Sights that joined late come last, whatever their keyframe.
    std::swap(landmark.measurements.front(), landmark.measurements.back());
    landmarks.push_back(landmark);
  }
  CorrelationSums sums;
  for (std::size_t l = 0; l < landmarks.size(); ++l)
    sums.set(static_cast<int>(l), landmarks[l], poses);
  return sums.correlation();
}

TEST(SightCorrelation, IndependentErrorsCountInFull) {
  for (int length : {8, 12, 25})
    EXPECT_NEAR(measured(0, length, 3000).variance_factor(), 1, 0.1) << length;
}

TEST(SightCorrelation, FindsTheAutocorrelation) {
  for (double rho : {0.3, 0.6, 0.75})
    for (int length : {12, 25}) EXPECT_NEAR(measured(rho, length, 3000).rho, rho, 0.1) << rho;
}

// Of a place that is driven by twice, the blobs' errors being the same again.
SightCorrelation measured_twice(double rho, int length, int tracks) {
  Random random(11);
  constexpr double kSigma = 1e-3;
  std::vector<Rigid3> poses;
  for (int p = 0; p < 2 * length; ++p)
    poses.push_back(Rigid3({1, 0, 0, 0}, {0.05 * (p % length), 0.001 * (p / length), 0}));
  CorrelationSums sums;
  for (int t = 0; t < tracks; ++t) {
    FilterLandmark landmark;
    landmark.position = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(4, 6)};
    std::vector<Eigen::Vector2d> errors{random.normal_vector<2>()};
    for (int p = 1; p < length; ++p)
      errors.push_back(rho * errors.back() + std::sqrt(1 - rho * rho) * random.normal_vector<2>());
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& error : errors) mean += error / length;
    for (int p = 0; p < 2 * length; ++p) {
      const auto at = static_cast<std::size_t>(p);
      PointMeasurement m;
      m.pose = p;
      m.sigma = kSigma;
      EXPECT_TRUE(project(poses[at], landmark.position, m.x));
      m.x += kSigma * (errors[at % errors.size()] - mean);
      landmark.measurements.push_back(m);
    }
    sums.set(t, landmark, poses);
  }
  return sums.correlation();
}

TEST(SightCorrelation, ASecondPassThatRepeatsTheErrorsOfTheFirstSaysNothingNew) {
  for (double rho : {0.3, 0.6}) {
    const double once = measured(rho, 25, 3000).variance_factor();
    EXPECT_GT(measured_twice(rho, 25, 3000).variance_factor(), 1.8 * once) << rho;
  }
}

// n times the variance of the mean of n errors: the sum of all pairs' correlations, over n.
TEST(SightCorrelation, TheFactorIsThatOfTheMeanOfATrack) {
  for (const double rho : {0.0, 0.3, 0.6, 0.9})
    for (const int n : {1, 2, 6, 12, 200}) {
      double pairs = 0;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) pairs += std::pow(rho, std::abs(i - j));
      EXPECT_NEAR((SightCorrelation{rho, 1.0 * n}.variance_factor()), pairs / n, 1e-9) << n;
    }
  EXPECT_NEAR(SightCorrelation{0.6}.variance_factor(), 4, 1e-12) << "of a track without end";
}

TEST(SightCorrelation, NeverPromisesMoreThanIndependence) {
  EXPECT_EQ(measured(-0.5, 12, 3000).variance_factor(), 1);
}

TEST(SightCorrelation, TakesTheUsualUntilTheMapCanTell) {
  const double usual = CorrelationSums().correlation().rho;
  EXPECT_GT(usual, 0.3);
  EXPECT_GT(measured(0, 12, 3).rho, 0.5 * usual);
  EXPECT_EQ(measured(0, 5, 3000).rho, usual);  // too short to show it
}

TEST(SightCorrelation, WhatATrackSaidBeforeIsForgotten) {
  FilterLandmark landmark;
  landmark.position = {0, 0, 5};
  const std::vector<Rigid3> poses(10);
  CorrelationSums sums;
  const double usual = sums.correlation().rho;
  for (int p = 0; p < 10; ++p) {
    PointMeasurement m;
    m.pose = p;
    m.sigma = 0.002;
    m.x = Eigen::Vector2d(0.002 * p, 0);
    landmark.measurements.push_back(m);
  }
  sums.set(0, landmark, poses);
  EXPECT_NE(sums.correlation().rho, usual);
  landmark.measurements.clear();
  sums.set(0, landmark, poses);
  EXPECT_EQ(sums.correlation().rho, usual);
}

}  // namespace
}  // namespace eifmap::test
