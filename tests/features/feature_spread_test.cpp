#include "features/feature_spread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace eifmap {
namespace {

std::vector<Contender> random_contenders(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Contender> contenders;
  contenders.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    contenders.push_back(
        {640 * unit(random), 480 * unit(random), 0.01f + unit(random), random() % 2 == 0 ? 1 : -1});
  return contenders;
}

TEST(FeatureSpread, KeepsAllWhenThereIsRoom) {
  const std::vector<std::size_t> kept = spread(random_contenders(50, 1), 640, 480, 80);
  EXPECT_EQ(std::set<std::size_t>(kept.begin(), kept.end()).size(), 50u);
}

TEST(FeatureSpread, KeepsAsManyAsAskedEachOnce) {
  const std::vector<std::size_t> kept = spread(random_contenders(500, 2), 640, 480, 80);
  EXPECT_EQ(kept.size(), 80u);
  EXPECT_EQ(std::set<std::size_t>(kept.begin(), kept.end()).size(), 80u);
  EXPECT_TRUE(spread({}, 640, 480, 80).empty());
}

TEST(FeatureSpread, ADominantCornerLeavesRoomForTheRest) {
  std::vector<Contender> contenders = random_contenders(300, 3);
  for (int i = 0; i < 1000; ++i)  // strong, all in one place
    contenders.push_back({5, 5, 1.5f, 1});
  const std::vector<std::size_t> kept = spread(contenders, 640, 480, 300);
  const auto elsewhere =
      std::count_if(kept.begin(), kept.end(), [](std::size_t i) { return i < 300; });
  EXPECT_GT(elsewhere, 200);
}

TEST(FeatureSpread, WithinATileAndSignTheStrongestWin) {
  std::vector<Contender> contenders;
  contenders.reserve(10);
  for (int i = 0; i < 10; ++i) contenders.push_back({5, 5, 0.1f * static_cast<float>(i + 1), 1});
  EXPECT_EQ(spread(contenders, 640, 480, 3), (std::vector<std::size_t>{9, 8, 7}));
}

TEST(FeatureSpread, TheOtherSignIsNotCrowdedOut) {
  std::vector<Contender> contenders(20, Contender{5, 5, 1.0f, 1});
  contenders.push_back({5, 5, 0.9f, -1});
  const std::vector<std::size_t> kept = spread(contenders, 640, 480, 2);
  EXPECT_EQ(kept, (std::vector<std::size_t>{0, 20}));
}

}  // namespace
}  // namespace eifmap
