// The factor of the sights' sigmas follows what they show.
#include "map/sight_noise.h"

#include <gtest/gtest.h>

#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

// Keyframes whose sights err `truth` times what their keypoints claim.
double factor_after(SightNoise& noise, double truth, int keyframes, int sights = 100) {
  for (int k = 0; k < keyframes; ++k) {
    FilterUpdate update;
    update.num_newest = sights;
    update.newest_spread = truth / noise.factor();
    const double before = noise.factor();
    const double change = noise.follow(update);
    EXPECT_NEAR(noise.factor(), before * change, 1e-12);
  }
  return noise.factor();
}

TEST(SightNoise, FollowsLargerErrorsUpToItsBound) {
  const MapperOptions options;
  SightNoise noise(options);
  EXPECT_EQ(noise.factor(), options.sigma_factor);
  EXPECT_NEAR(factor_after(noise, 4, 30), 4, 0.25 * 4);
  const double largest = options.sigma_factor * options.max_sigma_growth;
  EXPECT_LE(factor_after(noise, 100, 30), largest);
  EXPECT_GT(noise.factor(), 0.75 * largest);
}

TEST(SightNoise, ComesBackButNeverBelowTheSetting) {
  const MapperOptions options;
  SightNoise noise(options);
  factor_after(noise, 5, 30);
  EXPECT_LT(factor_after(noise, 0.5, 50), 1.3 * options.sigma_factor);
  EXPECT_GE(noise.factor(), options.sigma_factor);
}

TEST(SightNoise, DoesNotMoveWhereErrorsAreAsClaimedOrFewOrGrowthIsOff) {
  MapperOptions options;
  SightNoise right(options), few(options);
  EXPECT_EQ(factor_after(right, 0.9 * options.sigma_factor, 50), options.sigma_factor);
  EXPECT_EQ(factor_after(few, 10, 50, 10), options.sigma_factor);
  options.max_sigma_growth = 1;
  SightNoise off(options);
  EXPECT_EQ(factor_after(off, 10, 50), options.sigma_factor);
}

MapperStatistics map_stream(float claimed_share, const MapperOptions& options = {}) {
  const SyntheticStream stream;
  Mapper mapper(synthetic_camera(), options);
  for (int i = 0; i < 60; ++i) {
    FeatureFrame frame = stream.frame(i);
    for (Keypoint& keypoint : frame.keypoints) keypoint.sigma_px *= claimed_share;
    mapper.process(frame);
  }
  EXPECT_TRUE(mapper.audit().empty());
  return mapper.statistics();
}

// Keypoints that claim a third of their errors lose sights by it, unless the map finds out.
TEST(SightNoise, AMapFindsOutThatKeypointsClaimTooLittle) {
  const MapperStatistics right = map_stream(1), optimistic = map_stream(1.0f / 3);
  EXPECT_EQ(right.sigma_factor, MapperOptions().sigma_factor);
  EXPECT_GT(optimistic.sigma_factor, 2 * MapperOptions().sigma_factor);
  MapperOptions believing;
  believing.max_sigma_growth = 1;
  const MapperStatistics deceived = map_stream(1.0f / 3, believing);
  EXPECT_EQ(deceived.sigma_factor, MapperOptions().sigma_factor);
  const auto per_landmark = [](const MapperStatistics& s) {
    return static_cast<double>(s.observations) / static_cast<double>(s.landmarks);
  };
  EXPECT_GT(per_landmark(optimistic), 1.2 * per_landmark(deceived));
}

}  // namespace
}  // namespace eifmap
