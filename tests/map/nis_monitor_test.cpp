#include "map/nis_monitor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "map/innovations.h"
#include "mapper.h"
#include "simulation/feature_world.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

// By numbers drawn.
double drawn_mean(int degrees, double limit) {
  Random random(5);
  double sum = 0;
  int count = 0;
  for (int i = 0; i < 200000; ++i) {
    double squared = 0;
    for (int d = 0; d < degrees; ++d) squared += std::pow(random.normal(), 2);
    if (squared >= limit) continue;
    sum += squared;
    ++count;
  }
  return sum / count;
}

TEST(NisMonitor, KnowsTheMeanOfAChiSquareThatIsCutOff) {
  for (const int degrees : {1, 2, 5, 6})
    for (const double limit : {0.5, 3.0, 12.25, 30.0})
      EXPECT_NEAR(truncated_chi_square_mean(degrees, limit), drawn_mean(degrees, limit),
                  0.01 * degrees)
          << degrees << " below " << limit;
  EXPECT_NEAR(truncated_chi_square_mean(5, 1e3), 5, 1e-9);
  // Continuous where it is told by another formula.
  EXPECT_NEAR(truncated_chi_square_mean(5, 1.001e-3), truncated_chi_square_mean(5, 0.999e-3), 3e-6);
}

// Keyframes whose noise is `noise` times what is claimed, as the mapper gives them: cut off at the
// gate, a pose fitted to each.
NisMonitor watch(double noise, int keyframes, std::uint64_t seed) {
  constexpr int kSights = 100, kFitted = 6;
  Random random(seed);
  const auto squared = [&](int degrees) {
    double sum = 0;
    for (int d = 0; d < degrees; ++d) sum += std::pow(noise * random.normal(), 2);
    return sum;
  };
  const auto add = [](double one, double gate, NisSum& sum) {
    const bool within = one < gate * gate;
    ++(within ? sum.count : sum.beyond);
    if (within) sum.squared += one;
  };
  NisMonitor monitor;
  for (int k = 0; k < keyframes; ++k) {
    Innovations one;
    one.sights.fitted = kFitted;
    // As if the fit had made three of them exact.
    for (int i = 0; i < kSights; ++i)
      add(i < kFitted / 2 ? 0 : squared(2), kSightNisGate, one.sights);
    add(squared(5), kEdgeNisGate, one.edges);
    monitor.add(one, 4);
  }
  return monitor;
}

TEST(NisMonitor, FindsTheRatioBehindTheGate) {
  for (const double noise : {0.5, 0.8, 1.0, 1.25, 2.0}) {
    const NisMonitor monitor = watch(noise, NisMonitor::kWindow, 11);
    const NisRatio sights = monitor.ratio(InnovationKind::kSight);
    const NisRatio edges = monitor.ratio(InnovationKind::kEdge);
    EXPECT_NEAR(sights.ratio / (noise * noise), 1, 0.1) << noise;
    EXPECT_NEAR(edges.ratio / (noise * noise), 1, 4 * edges.sigma / edges.ratio) << noise;
    EXPECT_LT(sights.sigma, edges.sigma);
  }
}

TEST(NisMonitor, RaisesTheAlarmSoonWhereSigmasAreWrongAndNeverWhereTheyAreRight) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double noise : {0.5, 2.0}) EXPECT_TRUE(watch(noise, 20, seed).alarm()) << noise;
    for (int keyframes = 1; keyframes <= 60; ++keyframes)
      EXPECT_FALSE(watch(1, keyframes, seed).alarm()) << keyframes;
  }
}

TEST(NisMonitor, ForgetsWhatWas) {
  NisMonitor monitor = watch(2, 50, 1);
  ASSERT_TRUE(monitor.alarm());
  Innovations right;
  right.sights = {194 * truncated_chi_square_mean(2, 12.25) / 2, 100, 0, 6};
  for (int k = 0; k < NisMonitor::kWindow; ++k) monitor.add(right, 4);
  EXPECT_FALSE(monitor.alarm());
  EXPECT_NEAR(monitor.ratio(InnovationKind::kSight).ratio, 1, 1e-3);
}

TEST(NisMonitor, SaysNothingOfWhatThereIsNoneOf) {
  NisMonitor monitor;
  EXPECT_EQ(monitor.ratio(InnovationKind::kSight).count, 0);
  EXPECT_FALSE(monitor.alarm());
  Innovations few;
  few.sights = {0.1, 3, 0, 6};  // no more than the fit needs
  monitor.add(few, 4);
  EXPECT_EQ(monitor.ratio(InnovationKind::kSight).count, 0);
  EXPECT_FALSE(monitor.alarm());
}

// The whole mapper, on keypoints that claim what they should, half of it or twice as much.
TEST(NisMonitor, OfTheMapperSaysWhatIsWrong) {
  for (const double noise : {1.0, 0.5, 2.0}) {
    const FeatureWorld world({.motion = "sideways",
                              .num_frames = 40,
                              .noise_px = 0.5 * noise,
                              .sigma_px = 0.5 / MapperOptions().sigma_factor,
                              .seed = 4});
    Mapper mapper(world.camera(), {});
    FrameResult last;
    for (int i = 0; i < world.num_frames(); ++i) last = mapper.process(world.frame(i).frame);
    ASSERT_EQ(last.state, TrackingState::kTracking);
    const MapperStatistics& statistics = mapper.statistics();
    const NisRatio sights = statistics.nis.at(InnovationKind::kSight);
    EXPECT_GT(sights.count, 500);
    EXPECT_GT(statistics.nis.at(InnovationKind::kEdge).count, 5);
    EXPECT_NEAR(std::log2(sights.ratio), std::log2(noise * noise), 0.7) << noise;
    EXPECT_EQ(statistics.sigma_suspect, noise != 1);
    EXPECT_EQ(last.reason, noise == 1 ? Reason::kNone : Reason::kSigmaSuspect);
    EXPECT_EQ(last.detail.find("times what the keypoints' sigmas say") != std::string::npos,
              noise != 1)
        << last.detail;
  }
}

}  // namespace
}  // namespace eifmap::test
