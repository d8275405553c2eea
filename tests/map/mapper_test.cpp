// The whole mapper on feature frames of a known world.
#include "mapper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/feature_world.h"

namespace eifmap::test {
namespace {

Rigid3 sideways(int i) {
  return {so3_exp({0, 0.002 * i, 0}), {0.1 * i, 0.01 * i, 0.02 * i}};
}

// Largest distance from the truth, in units of the path, once the first pose and the length of the
// path are the truth's.
double trajectory_error(const std::vector<TimedPose>& estimate, Rigid3 (*truth)(int)) {
  const auto frame_of = [](const TimedPose& p) {
    return static_cast<int>((p.time_us - 1'000'000) / 100'000);
  };
  const Rigid3 origin = truth(frame_of(estimate.front()));
  const double length = (truth(frame_of(estimate.back())).translation - origin.translation).norm();
  const Rigid3 map_origin = estimate.front().world_from_camera;
  const double scale =
      length / (estimate.back().world_from_camera.translation - map_origin.translation).norm();
  double worst = 0;
  for (const TimedPose& pose : estimate) {
    const Eigen::Vector3d moved =
        scale * (map_origin.inverse() * pose.world_from_camera).translation;
    const Eigen::Vector3d expected = (origin.inverse() * truth(frame_of(pose))).translation;
    worst = std::max(worst, (moved - expected).norm() / length);
  }
  return worst;
}

bool same(const FrameResult& a, const FrameResult& b) {
  return a.state == b.state && a.source == b.source && a.reason == b.reason &&
         a.map_from_camera.translation == b.map_from_camera.translation &&
         a.map_from_camera.rotation.coeffs() == b.map_from_camera.rotation.coeffs() &&
         a.covariance == b.covariance && a.num_inliers == b.num_inliers;
}

TEST(Mapper, MapsAWalkFromTheScaleFitAndTheMap) {
  const SyntheticStream world;
  Mapper mapper(synthetic_camera(), {});
  for (int i = 0; i < 50; ++i) mapper.process(world.view(i, sideways(i)));
  const MapperStatistics& s = mapper.statistics();
  EXPECT_EQ(s.starts, 1);
  EXPECT_EQ(s.losses, 0);
  EXPECT_GE(s.sources.at(PoseSource::kScaleFit), s.tracked * 6 / 10);
  EXPECT_GE(s.edges, s.keyframes / 2);
  const std::vector<TimedPose> trajectory = mapper.final_trajectory();
  EXPECT_EQ(trajectory.size(), 50u);  // the start set is posed backwards
  EXPECT_LT(trajectory_error(trajectory, sideways), 0.01);
}

TEST(Mapper, MapsThroughWrongMatches) {
  const SyntheticStream world(3);
  Mapper mapper(synthetic_camera(), {});
  for (int i = 0; i < 50; ++i) mapper.process(world.view(i, sideways(i), 0.2));
  EXPECT_EQ(mapper.statistics().losses, 0);
  const std::vector<TimedPose> trajectory = mapper.final_trajectory();
  EXPECT_GE(trajectory.size(), 45u);
  EXPECT_LT(trajectory_error(trajectory, sideways), 0.02);
}

// A scale fit that always refuses leaves the other ways along the line, then the map alone.
TEST(Mapper, FallsBackOnOtherStartsWhereOneRefuses) {
  const SyntheticStream world;
  for (const bool fall_back : {false, true}) {
    MapperOptions options;
    options.scale_fit.min_inliers = 100000;
    options.tracking.fall_back = fall_back;
    Mapper mapper(synthetic_camera(), options);
    int along_line = 0, map_alone = 0;
    for (int i = 0; i < 40; ++i) {
      const PoseSource source = mapper.process(world.view(i, sideways(i))).source;
      along_line += source == PoseSource::kScaleFit ? 1 : 0;
      map_alone += source == PoseSource::kMapOnly ? 1 : 0;
    }
    EXPECT_EQ(mapper.statistics().losses, 0);
    EXPECT_EQ(along_line > 20, fall_back) << along_line;
    EXPECT_EQ(map_alone > 20, !fall_back) << map_alone;
  }
}

TEST(Mapper, SaysTheSameTwice) {
  const SyntheticStream world;
  Mapper first(synthetic_camera(), {}), second(synthetic_camera(), {});
  for (int i = 0; i < 30; ++i) {
    const FeatureFrame frame = world.view(i, sideways(i), 0.1);
    ASSERT_TRUE(same(first.process(frame), second.process(frame))) << i;
  }
}

TEST(Mapper, DoesNotStartWithoutABaseline) {
  const SyntheticStream world;
  for (const double turn : {0.0, 0.01}) {  // rad a frame: standing still, and turning on the spot
    Mapper mapper(synthetic_camera(), {});
    for (int i = 0; i < 25; ++i) {
      const FrameResult result =
          mapper.process(world.view(i, {so3_exp({0, turn * i, 0}), {2, 0, 0}}));
      ASSERT_EQ(result.state, TrackingState::kStarting);
      ASSERT_EQ(result.reason, Reason::kNoBaseline) << result.detail;
    }
    EXPECT_EQ(mapper.statistics().starts, 0);
  }
}

TEST(Mapper, BadFramesChangeNothing) {
  const SyntheticStream world;
  Mapper clean(synthetic_camera(), {}), disturbed(synthetic_camera(), {});
  for (int i = 0; i < 25; ++i) {
    const FeatureFrame frame = world.view(i, sideways(i));
    std::vector<std::pair<FeatureFrame, Reason>> bad(7, {frame, Reason::kBadFeatures});
    bad[0].first.width = 320, bad[0].second = Reason::kBadImageSize;
    bad[1].first.keypoints[3].u = std::numeric_limits<float>::quiet_NaN();
    bad[2].first.keypoints[3].laplacian_sign = 0;
    bad[3].first.keypoints[3].sigma_px = -1;
    bad[4].first.descriptors.pop_back();
    bad[5].first.keypoints[3].v = 480;
    bad[6].first.time_us = -1, bad[6].second = Reason::kTimeNotIncreasing;
    for (const auto& [hostile, reason] : bad) {
      if (i == 0 && reason == Reason::kTimeNotIncreasing) continue;  // the first may have any time
      const FrameResult refused = disturbed.process(hostile);
      ASSERT_TRUE(refused.rejected);
      ASSERT_EQ(refused.reason, reason) << refused.detail;
    }
    FeatureFrame other = frame;
    other.extractor = Extractor::kSift;
    if (i > 0) {
      EXPECT_EQ(disturbed.process(other).reason, Reason::kUnknownExtractor);
    }
    ASSERT_TRUE(same(clean.process(frame), disturbed.process(frame))) << i;
  }
  EXPECT_EQ(disturbed.statistics().rejected, 6 + 24 * 8);
  EXPECT_EQ(disturbed.statistics().frames, clean.statistics().frames);
}

// A short dark: where it was. A long one: anywhere in the map.
TEST(Mapper, LosesItselfInTheDarkAndFindsItselfAgain) {
  const SyntheticStream world;
  for (const bool is_long : {false, true}) {
    Mapper mapper(synthetic_camera(), {});
    for (int i = 0; i < 30; ++i) mapper.process(world.view(i, sideways(i)));
    const int light = is_long ? 56 : 36;
    for (int i = 30; i < light; ++i) {
      FeatureFrame dark = world.view(i, sideways(i));
      dark.keypoints.clear();
      dark.descriptors.clear();
      const FrameResult result = mapper.process(dark);
      EXPECT_EQ(result.state, TrackingState::kLost);
      EXPECT_NE(result.reason, Reason::kNone);
    }
    const FrameResult back = mapper.process(world.view(light, sideways(is_long ? 5 : 28)));
    EXPECT_EQ(back.state, TrackingState::kTracking);
    EXPECT_EQ(back.source == PoseSource::kRelocalized, is_long);
    EXPECT_EQ(mapper.statistics().losses, 1);
    EXPECT_EQ(mapper.statistics().starts, 1);
  }
}

TEST(Mapper, APublisherStartedAgainFindsItsMap) {
  const SyntheticStream world;
  Mapper mapper(synthetic_camera(), {});
  for (int i = 0; i < 30; ++i) mapper.process(world.view(i, sideways(i)));
  FeatureFrame again = world.view(0, sideways(5));  // the same recording from its start
  again.publisher = 8;
  const FrameResult result = mapper.process(again);
  EXPECT_FALSE(result.rejected);
  EXPECT_EQ(result.source, PoseSource::kRelocalized);
  EXPECT_EQ(mapper.statistics().starts, 1);
}

TEST(Mapper, OneWildTimeStampDoesNotLockTheInput) {
  const SyntheticStream world;
  Mapper mapper(synthetic_camera(), {});
  for (int i = 0; i < 30; ++i) mapper.process(world.view(i, sideways(i)));
  FeatureFrame wild = world.view(30, sideways(30));
  wild.time_us = 100'000'000'000'000;
  mapper.process(wild);
  int refused = 0;
  FrameResult result;
  for (int i = 31; i < 70; ++i) {
    result = mapper.process(world.view(i, sideways(30)));
    refused += result.rejected;
  }
  EXPECT_EQ(refused, 30);
  EXPECT_EQ(result.state, TrackingState::kTracking);
  EXPECT_EQ(mapper.statistics().starts, 1);
}

TEST(Mapper, BeginsANewMapWhereNothingIsKnown) {
  const SyntheticStream here(1), elsewhere(99);
  Mapper mapper(synthetic_camera(), {});
  for (int i = 0; i < 20; ++i) mapper.process(here.view(i, sideways(i)));
  FrameResult last;
  for (int i = 20; i < 80; ++i) last = mapper.process(elsewhere.view(i, sideways(i)));
  EXPECT_EQ(last.state, TrackingState::kTracking);
  EXPECT_EQ(last.map_id, 2);
  EXPECT_EQ(mapper.statistics().starts, 2);
  // The trajectory is that of the larger map, in one gauge.
  EXPECT_LT(trajectory_error(mapper.final_trajectory(), sideways), 0.02);
}

TEST(Mapper, RefusesOptionsByName) {
  MapperOptions options;
  options.landmark.min_views = 1;
  EXPECT_NE(options.problem().find("landmark.min_views"), std::string::npos);
  EXPECT_THROW(Mapper(synthetic_camera(), options), std::invalid_argument);
  Camera camera = synthetic_camera();
  camera.fx = -1;
  EXPECT_THROW(Mapper(camera, {}), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
