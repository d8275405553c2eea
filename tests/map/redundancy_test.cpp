// On known ground keyframes that say nothing new go.
#include "map/redundancy.h"

#include <gtest/gtest.h>

#include "mapper.h"
#include "support/feature_world.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

struct Walk {
  std::int64_t in_use = 0;
  std::size_t placed = 0;
  int lost = 0;
  ScaleState scale;
  MeasurementCounts::OfKind measurements;
  double farthest = 0;
};

// So many times along 4 m and back.
Walk to_and_fro(int times, const MapperOptions& options, bool measured = false) {
  constexpr int kSteps = 40;
  const SyntheticStream world;
  Mapper mapper(synthetic_camera(), options);
  Walk walk;
  for (int i = 0; i < 2 * kSteps * times; ++i) {
    const int at = i % (2 * kSteps);
    const double x = 0.1 * (at < kSteps ? at : 2 * kSteps - at);
    AbsoluteMeasurement position;
    position.time_us = world.frame(i).time_us;
    position.position = {100 + x, 50, 0};
    position.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    if (measured) mapper.add_measurement(position);
    const FrameResult result =
        mapper.process(world.view(i, {Eigen::Quaterniond::Identity(), {x, 0, 0}}));
    walk.lost += result.state == TrackingState::kLost;
  }
  for (const std::string& problem : mapper.audit()) ADD_FAILURE() << problem;
  walk.scale = mapper.statistics().scale;
  if (measured)
    walk.measurements = mapper.statistics().measurements.kinds.at(MeasurementKind::kPosition);
  for (const TimedPose& pose : mapper.final_trajectory())
    walk.farthest = std::max(walk.farthest, pose.world_from_camera.translation.norm());
  walk.in_use = mapper.statistics().keyframes;
  walk.placed = mapper.final_trajectory().size();
  return walk;
}

TEST(Redundancy, KnownGroundDoesNotMakeTheMapGrowWithoutEnd) {
  const MapperOptions options;
  MapperOptions keeping;
  keeping.keyframe.redundant_share = 2;
  const Walk once = to_and_fro(1, options), often = to_and_fro(4, options);
  const Walk kept = to_and_fro(4, keeping);
  EXPECT_EQ(often.lost, 0);
  EXPECT_EQ(often.placed, kept.placed) << "also those that are relative to what went";
  EXPECT_LE(often.in_use, once.in_use + options.keyframe.keep_newest);
  EXPECT_GT(kept.in_use, often.in_use);
}

// Nor with a position of each image, which go with their keyframes.
TEST(Redundancy, NorDoesTheMapGrowWithSteadyPositions) {
  const MapperOptions options;
  const Walk without = to_and_fro(4, options), once = to_and_fro(1, options, true);
  const Walk often = to_and_fro(4, options, true);
  EXPECT_EQ(often.lost, 0);
  EXPECT_LE(often.in_use, without.in_use + 3);
  EXPECT_GT(often.measurements.dropped, 0);
  EXPECT_GT(often.measurements.used - often.measurements.dropped, 8);
  ASSERT_EQ(often.scale.status, ScaleStatus::kFixed);
  EXPECT_LT(often.scale.sigma, 0.02);
  EXPECT_NEAR(often.farthest, 4, 0.05);
  EXPECT_NEAR(once.farthest, 4, 0.05);
}

TEST(Redundancy, CountsLandmarksThatEnoughOthersSee) {
  const SyntheticStream world;
  const Map map = scene_with_landmarks(world, 6);
  EXPECT_GT(redundancy(map, 2, 2), redundancy(map, 2, 5));
  EXPECT_EQ(redundancy(map, 2, 6), 0) << "there are five others";
  KeyframeOptions options;
  options.keep_newest = 2;
  EXPECT_FALSE(redundant_keyframe(map, 5, options)) << "none has six views";
  options.enough_views = 2;
  options.redundant_share = 0.01;
  const auto found = redundant_keyframe(map, 5, options);
  ASSERT_TRUE(found);
  EXPECT_TRUE(*found == 2 || *found == 3);
  options.redundant_share = 2;
  EXPECT_FALSE(redundant_keyframe(map, 5, options));
}

}  // namespace
}  // namespace eifmap::test
