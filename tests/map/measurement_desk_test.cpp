#include "map/measurement_desk.h"

#include <gtest/gtest.h>

#include "support/map_scene.h"

namespace eifmap::test {
namespace {

// Of the scene's keyframes, whose times are those of the stream's frames.
class MeasurementDeskTest : public testing::Test {
 protected:
  MeasurementDeskTest() {
    for (int k = 0; k < map_.num_keyframes(); ++k)
      desk_.add_frame(PlacedFrame::as_keyframe(time_us(k), k));
  }
  std::int64_t time_us(int k) const { return map_.keyframe(k).time_us; }
  void add(int k, std::int64_t seq) {
    AbsoluteMeasurement m;
    m.id = {1, seq};
    m.time_us = time_us(k);
    EXPECT_EQ(desk_.add(m), Reason::kNone);
  }
  static std::vector<std::int64_t> seqs(const MeasurementDesk::Taken& taken) {
    std::vector<std::int64_t> seqs;
    for (const auto& entry : taken.entries) seqs.push_back(entry.measurement.id.seq);
    EXPECT_EQ(seqs.size(), taken.placed.size());
    return seqs;
  }
  std::int64_t num_refused(Reason reason) const {
    const auto& refusals = desk_.refused().refusals;
    const auto found = refusals.find(reason);
    return found == refusals.end() ? 0 : found->second;
  }

  using Seqs = std::vector<std::int64_t>;
  const SyntheticStream world_;
  const Map map_ = scene_with_landmarks(world_, 4);
  MeasurementDesk desk_{MeasurementOptions{}};
};

TEST_F(MeasurementDeskTest, WhatAKeyframeDidNotTakeComesWithTheNext) {
  add(1, 0);
  add(2, 1);
  auto taken = desk_.take(map_, 1);
  EXPECT_EQ(seqs(taken), (Seqs{0, 1}));
  EXPECT_EQ(desk_.num_waiting(), 0);
  add(3, 2);
  desk_.put_back(std::move(taken.entries), Reason::kFilterFailed);
  EXPECT_EQ(desk_.num_waiting(), 3);
  EXPECT_EQ(seqs(desk_.take(map_, 1)), (Seqs{0, 1, 2})) << "in the order of adding";
  EXPECT_TRUE(desk_.refused().kinds.empty());
}

TEST_F(MeasurementDeskTest, WithTwoThatFailedTheyAreRefused) {
  add(1, 0);
  desk_.put_back(desk_.take(map_, 1).entries, Reason::kFilterFailed);
  add(2, 1);
  desk_.put_back(desk_.take(map_, 1).entries, Reason::kFilterFailed);
  EXPECT_EQ(num_refused(Reason::kFilterFailed), 1);
  EXPECT_EQ(seqs(desk_.take(map_, 1)), Seqs{1});
}

TEST_F(MeasurementDeskTest, WaitsForTheImageOfItsTimeWithinReason) {
  AbsoluteMeasurement m;
  m.time_us = time_us(3) + 59'000'000;
  EXPECT_EQ(desk_.add(m), Reason::kNone);
  m.time_us = time_us(3) + 61'000'000;
  EXPECT_EQ(desk_.add(m), Reason::kNone);
  EXPECT_TRUE(desk_.take(map_, 1).placed.empty());
  EXPECT_EQ(desk_.num_waiting(), 1);
  EXPECT_EQ(num_refused(Reason::kMeasurementWithoutFrame), 1) << "by a wrong clock";
}

TEST_F(MeasurementDeskTest, AFullMapIsNoFaultOfTheirs) {
  add(1, 0);
  for (int i = 0; i < 5; ++i) desk_.put_back(desk_.take(map_, 1).entries, Reason::kMapFull);
  for (int i = 0; i < 5; ++i) desk_.put_back(desk_.take(map_, 1).entries, Reason::kNone);
  EXPECT_EQ(seqs(desk_.take(map_, 1)), Seqs{0});
  EXPECT_TRUE(desk_.refused().kinds.empty());
}

// Between two frames the camera is turned as far as the time has gone.
TEST_F(MeasurementDeskTest, GravityIsOfTheKeyframeNearest) {
  MeasurementDesk desk{MeasurementOptions{}};
  PlacedFrame turned = PlacedFrame::as_keyframe(time_us(1) + 40'000, 1);
  turned.keyframe_from_camera.rotation = so3_exp({0.4, 0, 0});
  turned.turn_covariance = 0.0625F * Eigen::Matrix3f::Identity();
  desk.add_frame(PlacedFrame::as_keyframe(time_us(1), 1));
  desk.add_frame(turned);
  AbsoluteMeasurement m;
  m.kind = MeasurementKind::kGravity;
  m.down = {0, 5, 0};
  m.sigma = 0.4;
  for (const std::int64_t after_us : {10'000, 30'000}) {
    m.time_us = time_us(1) + after_us;
    EXPECT_EQ(desk.add(m), Reason::kNone);
  }
  const MeasurementDesk::Taken taken = desk.take(map_, 1);
  ASSERT_EQ(taken.placed.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    const PlacedMeasurement& placed = taken.placed[k];
    EXPECT_EQ(placed.points.front().keyframe, 1);
    const Eigen::Vector3d expected = so3_exp({k == 0 ? 0.1 : 0.3, 0, 0}) * Eigen::Vector3d::UnitY();
    EXPECT_LT((placed.value - expected).norm(), 1e-12);
    EXPECT_NEAR(placed.covariance(0, 0), k == 0 ? 0.16 : 0.16 + 0.0625, 1e-12);
  }
}

}  // namespace
}  // namespace eifmap::test
