// Which way is down and distances of landmarks, through the mapper: a camera that goes sideways.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

constexpr int kFrames = 60;
// The camera's frame at the start is the map's: y down, but for a tilt.
const Eigen::Quaterniond kTrueEarth =
    Eigen::Quaterniond::FromTwoVectors(-Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()) *
    so3_exp({0.1, 0, 0.2});

Rigid3 walk(int i) {
  return {so3_exp({0, 0.02 * std::sin(0.2 * i), 0.03 * std::sin(0.15 * i)}), {0.1 * i, 0, 0}};
}

AbsoluteMeasurement gravity_of(int i, const Eigen::Vector3d& off = {0, 0, 0}) {
  AbsoluteMeasurement m;
  m.id = {3, i};
  m.kind = MeasurementKind::kGravity;
  m.time_us = 1'000'000 + 100'000 * i;
  m.down = 9.81 * (so3_exp(off) * (walk(i).rotation.conjugate() *
                                   (kTrueEarth.conjugate() * Eigen::Vector3d(0, 0, -1))));
  m.sigma = 0.01;
  return m;
}

AbsoluteMeasurement position_of(int i) {
  AbsoluteMeasurement m;
  m.time_us = 1'000'000 + 100'000 * i;
  m.position = kTrueEarth * walk(i).translation + Eigen::Vector3d(100, 200, 30);
  m.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  return m;
}

struct Walk {
  Mapper mapper{synthetic_camera(), {}};
  std::vector<FrameResult> results;
  SyntheticStream stream{3};

  template <class Give>
  void go(const Give& give) {
    for (int i = 0; i < kFrames; ++i) {
      give(mapper, i);
      results.push_back(mapper.process(stream.view(i, walk(i))));
    }
  }
  const MeasurementCounts::OfKind& counts(MeasurementKind kind) const {
    return mapper.statistics().measurements.kinds.at(kind);
  }
};

double tilt_off(const EarthView& view) {
  const Eigen::Vector3d up =
      view.earth_from_map.rotation * (kTrueEarth.conjugate() * Eigen::Vector3d::UnitZ());
  return std::acos(std::min(1.0, up.z()));
}

TEST(GravityInTheMapper, LevelsTheMapAndLeavesItsScaleFree) {
  Walk walk;
  walk.go([](Mapper& mapper, int i) {
    EXPECT_EQ(mapper.add_measurement(gravity_of(i)), Reason::kNone);
  });
  const auto view = walk.mapper.in_earth();
  ASSERT_TRUE(view);
  EXPECT_FALSE(view->placed);
  EXPECT_LT(tilt_off(*view), 0.01);
  EXPECT_LT(view->earth_from_map.translation.norm(), 1e-9);
  EXPECT_EQ(walk.results.back().scale.status, ScaleStatus::kFree);
  EXPECT_EQ(walk.results.back().map_epoch, 0);
  // Of each keyframe its own, and what it is off by.
  for (const EarthView::Keyframe& keyframe : view->keyframes) {
    ASSERT_TRUE(keyframe.covariance.allFinite()) << keyframe.id;
    const Eigen::Matrix3d turn = keyframe.earth_from_camera.matrix();
    const Eigen::Matrix3d of_turn =
        turn * keyframe.covariance.bottomRightCorner<3, 3>() * turn.transpose();
    EXPECT_GT(of_turn(0, 0), 0) << keyframe.id;
    EXPECT_LT(std::sqrt(of_turn(0, 0)), 0.01) << keyframe.id;
  }
  const auto& counts = walk.counts(MeasurementKind::kGravity);
  EXPECT_GT(counts.used, 5);
  EXPECT_EQ(counts.used + counts.refused + walk.mapper.statistics().measurements_waiting, kFrames);
  // But for those from before the map began.
  std::map<Reason, std::int64_t> refusals = walk.mapper.statistics().measurements.refusals;
  EXPECT_LE(refusals[Reason::kMeasurementWithoutFrame], 1);
  EXPECT_EQ(refusals[Reason::kMeasurementSpare] + refusals[Reason::kMeasurementWithoutFrame],
            counts.refused);
  EXPECT_TRUE(walk.mapper.audit().empty());
}

TEST(GravityInTheMapper, WrongOnesAreRefusedAlsoAmongTheFirst) {
  Walk walk;
  walk.go([](Mapper& mapper, int i) {
    const bool is_wrong = i == 1 || i == 25;
    mapper.add_measurement(gravity_of(i, {is_wrong ? 0.6 : 0.0, 0, 0}));
  });
  ASSERT_TRUE(walk.mapper.in_earth());
  EXPECT_LT(tilt_off(*walk.mapper.in_earth()), 0.01);
  EXPECT_EQ(walk.mapper.statistics().losses, 0);
}

TEST(GravityInTheMapper, TwoAreNotEnough) {
  Walk walk;
  walk.go([](Mapper& mapper, int i) {
    if (i == 5 || i == 50) mapper.add_measurement(gravity_of(i));
  });
  EXPECT_FALSE(walk.mapper.in_earth());
  EXPECT_EQ(walk.mapper.statistics().measurements_waiting, 2);
}

// Positions on a straight line do not tell how earth is turned about it; which way is down does.
TEST(GravityInTheMapper, TellsWhatPositionsOnALineLeaveOpen) {
  for (const bool gravity_first : {true, false}) {
    Walk walk;
    walk.go([gravity_first](Mapper& mapper, int i) {
      if ((i < 20) == gravity_first) mapper.add_measurement(gravity_of(i));
      if (i >= 20 || !gravity_first) mapper.add_measurement(position_of(i));
    });
    const auto view = walk.mapper.in_earth();
    ASSERT_TRUE(view) << gravity_first;
    EXPECT_TRUE(view->placed);
    EXPECT_LT(tilt_off(*view), 0.01) << gravity_first;
    const double turned = view->earth_from_map.rotation.angularDistance(kTrueEarth);
    EXPECT_LT(turned, 0.02) << gravity_first;
    EXPECT_EQ(walk.results.back().scale.status, ScaleStatus::kFixed);
    for (const EarthView::Keyframe& keyframe : view->keyframes)
      EXPECT_TRUE(keyframe.covariance.allFinite());
  }
}

// Two that the map knows well, and how far they are from each other in it.
struct Pair {
  std::array<std::int64_t, 2> landmark;
  double length;
};
Pair a_pair(const Mapper& mapper) {
  std::vector<LandmarkView> landmarks = mapper.landmarks();
  std::stable_sort(landmarks.begin(), landmarks.end(),
                   [](const LandmarkView& a, const LandmarkView& b) {
                     return a.num_observations > b.num_observations;
                   });
  const std::vector<KeyframeView> keyframes = mapper.keyframes();
  const auto place = [&](const LandmarkView& l) {
    for (const KeyframeView& keyframe : keyframes)
      if (keyframe.id == l.anchor)
        return Eigen::Vector3d(keyframe.map_from_camera * l.position_in_anchor);
    return Eigen::Vector3d(0, 0, 0);
  };
  std::size_t other = 1;
  while ((place(landmarks[0]) - place(landmarks[other])).norm() < 1) ++other;
  return {{landmarks[0].id, landmarks[other].id},
          (place(landmarks[0]) - place(landmarks[other])).norm()};
}

AbsoluteMeasurement distance_of(const Pair& pair, double metres, int i, std::int64_t map_id = 1) {
  AbsoluteMeasurement m;
  m.id = {4, i};
  m.kind = MeasurementKind::kLandmarks;
  m.time_us = 1'000'000 + 100'000 * i;
  m.map_id = map_id;
  m.landmark = pair.landmark;
  m.length = metres;
  m.sigma = 0.005;
  return m;
}

TEST(LandmarkDistanceInTheMapper, MakesTheMapMetric) {
  constexpr double kMetresPerUnit = 3;
  Walk walk;
  Pair pair;
  walk.go([&](Mapper& mapper, int i) {
    if (i != 30) return;
    pair = a_pair(mapper);
    EXPECT_EQ(mapper.add_measurement(distance_of(pair, kMetresPerUnit * pair.length, i)),
              Reason::kNone);
  });
  const FrameResult& last = walk.results.back();
  EXPECT_EQ(last.scale.status, ScaleStatus::kFixed);
  EXPECT_NEAR(last.scale.metres_per_unit, kMetresPerUnit, 0.05 * kMetresPerUnit);
  EXPECT_LT(last.scale.sigma, 0.05);
  EXPECT_GT(last.scale.sigma, 0.001);
  EXPECT_EQ(last.map_epoch, 1);
  EXPECT_EQ(walk.counts(MeasurementKind::kLandmarks).used, 1);
  EXPECT_TRUE(walk.mapper.audit().empty());
}

TEST(LandmarkDistanceInTheMapper, OfLandmarksThatAreNotThereIsRefused) {
  Walk walk;
  walk.go([&](Mapper& mapper, int i) {
    if (i != 30) return;
    Pair pair = a_pair(mapper);
    mapper.add_measurement(distance_of(pair, 3, i, 7));  // of another map
    pair.landmark[1] = 1'000'000'000'000;
    mapper.add_measurement(distance_of(pair, 3, i + 1));
  });
  EXPECT_EQ(walk.results.back().scale.status, ScaleStatus::kFree);
  EXPECT_EQ(walk.mapper.statistics().measurements.refusals.at(Reason::kMeasurementWithoutLandmark),
            2);
}

TEST(LandmarkDistanceInTheMapper, AWrongOneIsRefusedByAMetricMap) {
  Walk walk;
  walk.go([&](Mapper& mapper, int i) {
    if (i == 30) mapper.add_measurement(distance_of(a_pair(mapper), a_pair(mapper).length, i));
    if (i != 45) return;
    const Pair pair = a_pair(mapper);
    mapper.add_measurement(distance_of(pair, 1.5 * pair.length, i));
  });
  EXPECT_EQ(walk.counts(MeasurementKind::kLandmarks).used, 1);
  EXPECT_EQ(walk.mapper.statistics().measurements.refusals.at(Reason::kMeasurementGated), 1);
  EXPECT_EQ(walk.mapper.statistics().losses, 0);
}

}  // namespace
}  // namespace eifmap
