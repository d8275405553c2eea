// Absolute measurements through the mapper: a camera that goes sideways, with true positions.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/similarity.h"
#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

constexpr int kFrames = 60;
const Rigid3 kEarth{so3_exp({0.3, 1.2, -0.4}), {100, 200, -30}};

AbsoluteMeasurement position_of(int i, const Eigen::Vector3d& off = {0, 0, 0}) {
  AbsoluteMeasurement m;
  m.time_us = 1'000'000 + 100'000 * i;
  m.position = kEarth * Eigen::Vector3d(0.1 * i, 0, 0) + off;
  m.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  return m;
}

struct Walk {
  Mapper mapper{synthetic_camera(), {}};
  std::vector<FrameResult> results;
  std::vector<MapUpdate> updates;

  template <class Give>
  void go(const Give& give) {
    const SyntheticStream stream(3);
    for (int i = 0; i < kFrames; ++i) {
      give(mapper, i);
      results.push_back(mapper.process(stream.frame(i)));
      if (results.back().map_updated) updates.push_back(mapper.map_update());
    }
  }
};

void expect_true_lengths(const Walk& walk, double within) {
  const std::vector<TimedPose> path = walk.mapper.final_trajectory();
  ASSERT_GT(path.size(), 40u);
  const auto length =
      (path.back().world_from_camera.translation - path.front().world_from_camera.translation)
          .norm();
  const double truth = 1e-6 * static_cast<double>(path.back().time_us - path.front().time_us);
  EXPECT_NEAR(length / truth, 1, within);
}

TEST(Measurements, WithoutAnyTheScaleIsFree) {
  Walk walk;
  walk.go([](Mapper&, int) {});
  EXPECT_EQ(walk.results.back().scale.status, ScaleStatus::kFree);
  EXPECT_EQ(walk.results.back().map_epoch, 0);
  EXPECT_TRUE(walk.mapper.statistics().measurements.kinds.empty());
}

TEST(Measurements, PositionsMakeTheMapMetricAtOnce) {
  Walk walk;
  walk.go([](Mapper& mapper, int i) {
    if (i % 5 != 0) return;
    EXPECT_EQ(mapper.add_measurement(position_of(i)), Reason::kNone);
  });
  const FrameResult& last = walk.results.back();
  EXPECT_EQ(last.scale.status, ScaleStatus::kFixed);
  EXPECT_EQ(last.map_epoch, 1);
  EXPECT_GT(last.scale.sigma, 0);
  EXPECT_LT(last.scale.sigma, 0.05);
  expect_true_lengths(walk, 0.01);
  EXPECT_TRUE(walk.mapper.audit().empty());
  // A whole map is sent when it changes, and never a step of it that mixes units.
  int whole = 0;
  for (const MapUpdate& update : walk.updates) {
    if (update.base_seq != -1) continue;
    ++whole;
    EXPECT_EQ(update.map_epoch, whole - 1);
  }
  EXPECT_EQ(whole, 2);
  // The path goes on where it was: of two frames one after the other in one epoch.
  for (std::size_t i = 1; i < walk.results.size(); ++i) {
    const FrameResult &a = walk.results[i - 1], &b = walk.results[i];
    const double step = (b.map_from_camera.translation - a.map_from_camera.translation).norm();
    if (a.map_epoch == 1) {
      EXPECT_NEAR(step, 0.1, 0.03) << i;
    }
  }
}

TEST(Measurements, OneDistanceMakesTheMapMetric) {
  for (const MeasurementKind kind : {MeasurementKind::kDistance, MeasurementKind::kOdometry}) {
    Walk walk;
    walk.go([kind](Mapper& mapper, int i) {
      if (i != 30) return;
      AbsoluteMeasurement m;
      m.kind = kind;
      m.time_us = 1'000'000 + 100'000 * 10;
      m.until_us = 1'000'000 + 100'000 * 25;
      m.length = 1.5;
      m.sigma = 0.005;
      EXPECT_EQ(mapper.add_measurement(m), Reason::kNone);
    });
    EXPECT_EQ(walk.results.back().map_epoch, 1) << name(kind);
    EXPECT_EQ(walk.mapper.statistics().measurements.kinds.at(kind).used, 1);
    expect_true_lengths(walk, 0.02);
  }
}

// Each that was given is used, refused or still waits, also where the map takes no keyframe more:
// none may go, since each has a way that ends there.
TEST(Measurements, NoneIsLostWithAKeyframeThatDoesNotCome) {
  MapperOptions full;
  full.bound.max_keyframes = 20;
  Mapper mapper(synthetic_camera(), full);
  const SyntheticStream stream(3);
  std::int64_t given = 0;
  for (int i = 0; i < 130; ++i) {
    AbsoluteMeasurement m;
    m.kind = MeasurementKind::kDistance;
    m.time_us = stream.frame(i).time_us - 200'000;
    m.until_us = m.time_us + 200'000;
    m.length = 0.2;
    m.sigma = 0.002;
    given += mapper.add_measurement(m) == Reason::kNone;
    mapper.process(stream.frame(i));
  }
  const MapperStatistics& statistics = mapper.statistics();
  ASSERT_TRUE(statistics.reasons.contains(Reason::kMapFull)) << "else this shows nothing";
  const auto& counts = statistics.measurements.kinds.at(MeasurementKind::kDistance);
  EXPECT_EQ(counts.used + counts.refused + statistics.measurements_waiting, given);
  EXPECT_GT(statistics.measurements_waiting, 20);
}

TEST(Measurements, WrongOnesAreRefusedCountedAndCostNothing) {
  Walk walk;
  walk.go([](Mapper& mapper, int i) {
    if (i % 5 == 0) mapper.add_measurement(position_of(i));
    if (i == 42) mapper.add_measurement(position_of(41, {0, 30, 0}));
    if (i != 43) return;
    AbsoluteMeasurement bad = position_of(43);
    bad.position.x() = std::nan("");
    EXPECT_EQ(mapper.add_measurement(bad), Reason::kBadMeasurement);
    bad = position_of(43);
    bad.covariance.setZero();
    EXPECT_EQ(mapper.add_measurement(bad), Reason::kBadMeasurementCovariance);
    EXPECT_EQ(mapper.add_measurement(position_of(-100)), Reason::kNone);  // of no frame
  });
  const MeasurementCounts& counts = walk.mapper.statistics().measurements;
  EXPECT_EQ(counts.refusals.at(Reason::kMeasurementGated), 1);
  EXPECT_EQ(counts.refusals.at(Reason::kMeasurementWithoutFrame), 1);
  EXPECT_EQ(counts.refusals.at(Reason::kBadMeasurement), 1);
  EXPECT_EQ(counts.refusals.at(Reason::kBadMeasurementCovariance), 1);
  EXPECT_EQ(counts.kinds.at(MeasurementKind::kPosition).refused, 4);
  EXPECT_EQ(walk.mapper.statistics().losses, 0);
  expect_true_lengths(walk, 0.01);
}

}  // namespace
}  // namespace eifmap
