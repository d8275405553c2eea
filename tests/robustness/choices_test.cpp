#include "robustness/choices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace eifmap::test {
namespace {

TEST(Choices, BurstsLoseTheirShare) {
  std::set<int> lengths;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const int n = 201;
    const std::vector<int> frames = without_bursts(n, 0.1, random);
    ASSERT_EQ(frames.size(), 181u);
    EXPECT_EQ(frames.front(), 0);
    EXPECT_EQ(frames.back(), n - 1);
    int short_ones = 0;
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const int lost = frames[k] - frames[k - 1] - 1;
      ASSERT_GE(lost, 0);
      ASSERT_LE(lost, 8);
      lengths.insert(lost);
      short_ones += lost == 1 ? 1 : 0;
    }
    EXPECT_LE(short_ones, 1) << "only the last burst may be shorter than 2";
  }
  EXPECT_EQ(lengths.size(), 9u) << "every length from none to 8 occurs";
}

TEST(Choices, BurstsAreAnywhere) {
  std::vector<int> times_lost(60, 0);
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Random random(seed);
    std::vector<int> left(60, 0);
    for (const int i : without_bursts(60, 0.1, random)) left[i] = 1;
    for (int i = 0; i < 60; ++i) times_lost[i] += 1 - left[i];
  }
  // Fewer near the ends, where bursts only reach from one side.
  for (int i = 10; i < 50; ++i) EXPECT_NEAR(times_lost[i], 200, 80) << i;
}

TEST(Choices, NothingIsLostOfNothing) {
  Random random(1);
  EXPECT_EQ(without_bursts(3, 0.1, random), (std::vector<int>{0, 1, 2}));
  EXPECT_THROW(without_bursts(10, 0.6, random), std::invalid_argument);
}

TEST(Choices, GainsStepAndComeBack) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const std::vector<double> gains = gain_steps(500, 0.2, random);
    ASSERT_EQ(gains.size(), 500u);
    EXPECT_EQ(gains.front(), 1);
    const std::set<double> all(gains.begin(), gains.end());
    EXPECT_EQ(all, (std::set<double>{0.8, 1, 1.2}));
    int held = 1;
    for (std::size_t i = 1; i < gains.size(); ++i) {
      if (gains[i] == gains[i - 1]) {
        ++held;
        continue;
      }
      EXPECT_NEAR(std::abs(gains[i] - gains[i - 1]), 0.2, 1e-12);
      EXPECT_GE(held, 10);
      EXPECT_LE(held, 30);
      held = 1;
    }
  }
}

TEST(Choices, StrangeFramesComeAnywhereBetween) {
  Random random(4);
  const std::vector<int> counts = between(1000, 300, random);
  ASSERT_EQ(counts.size(), 999u);
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0), 300);
  EXPECT_GT(*std::max_element(counts.begin(), counts.end()), 1) << "some come together";
  const int early = std::accumulate(counts.begin(), counts.begin() + 500, 0);
  EXPECT_NEAR(early, 150, 45);
  EXPECT_THROW(between(1, 1, random), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
