#include "features/matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace eifmap {
namespace {

// Descriptors around a few centres, so that near ones, ties and ambiguous ones all occur.
FeatureGroup random_group(int count, int spread, unsigned seed) {
  std::mt19937 random(seed);
  FeatureGroup group;
  for (int i = 0; i < count; ++i) {
    group.index.push_back(3 * i + 1);
    std::mt19937 centre(random() % 40);
    for (int k = 0; k < kDescriptorSize; ++k) {
      const int jitter =
          static_cast<int>(random() % static_cast<unsigned>(2 * spread + 1)) - spread;
      group.descriptors.push_back(
          static_cast<std::int8_t>(static_cast<int>(centre() % 64) - 32 + jitter));
    }
  }
  return group;
}

const std::int8_t* descriptor(const FeatureGroup& group, std::size_t i) {
  return &group.descriptors[i * kDescriptorSize];
}

int brute_force_distance(const std::int8_t* a, const std::int8_t* b) {
  int sum = 0;
  for (int k = 0; k < kDescriptorSize; ++k)
    sum += (int{a[k]} - int{b[k]}) * (int{a[k]} - int{b[k]});
  return sum;
}

// The order of all of b by distance to one of a; ties by index.
std::vector<std::pair<int, std::size_t>> ranking(const std::int8_t* a, const FeatureGroup& b) {
  std::vector<std::pair<int, std::size_t>> order;
  for (std::size_t k = 0; k < b.index.size(); ++k)
    order.emplace_back(brute_force_distance(a, descriptor(b, k)), k);
  std::sort(order.begin(), order.end());
  return order;
}

std::vector<Match> oracle(const FeatureGroup& a, const FeatureGroup& b,
                          const MatchOptions& options) {
  std::vector<Match> matches;
  for (std::size_t i = 0; i < a.index.size(); ++i) {
    const auto order = ranking(descriptor(a, i), b);
    if (order.empty()) continue;
    const double first = std::sqrt(order[0].first) / 254;
    if (first > options.max_distance) continue;
    if (order.size() > 1 && first >= options.max_ratio * (std::sqrt(order[1].first) / 254))
      continue;
    if (options.mutual && ranking(descriptor(b, order[0].second), a)[0].second != i) continue;
    matches.push_back({a.index[i], b.index[order[0].second], order[0].first});
  }
  return matches;
}

void expect_same(const std::vector<Match>& found, const std::vector<Match>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].a, expected[i].a);
    EXPECT_EQ(found[i].b, expected[i].b);
    EXPECT_EQ(found[i].distance, expected[i].distance);
  }
}

TEST(DescriptorDistance, IsTheSumOfSquaresOverTheWholeRange) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    std::int8_t a[kDescriptorSize], b[kDescriptorSize];
    for (int k = 0; k < kDescriptorSize; ++k) {
      a[k] = static_cast<std::int8_t>(random());
      b[k] = static_cast<std::int8_t>(random());
    }
    ASSERT_EQ(descriptor_distance(a, b), brute_force_distance(a, b));
  }
  std::int8_t low[kDescriptorSize], high[kDescriptorSize];
  std::fill_n(low, kDescriptorSize, std::int8_t{-128});
  std::fill_n(high, kDescriptorSize, std::int8_t{127});
  EXPECT_EQ(descriptor_distance(low, high), 64 * 255 * 255);
}

TEST(Match, AgreesWithTheOracle) {
  for (const bool mutual : {true, false})
    for (const double ratio : {0.6, 0.8, 0.95, 1.0})
      for (const int spread : {2, 12}) {
        const FeatureGroup a = random_group(70, spread, 1), b = random_group(60, spread, 2);
        MatchOptions options;
        options.mutual = mutual;
        options.max_ratio = ratio;
        options.max_distance = 1;
        expect_same(match(a, b, options), oracle(a, b, options));
      }
}

TEST(Match, KeepsToTheLargestDistance) {
  const FeatureGroup a = random_group(50, 12, 3), b = random_group(50, 12, 4);
  MatchOptions options;
  options.max_ratio = 1;
  std::size_t before = 0;
  for (const double distance : {0.1, 0.25, 0.35, 0.6}) {
    options.max_distance = distance;
    const std::vector<Match> matches = match(a, b, options);
    expect_same(matches, oracle(a, b, options));
    EXPECT_GE(matches.size(), before);
    before = matches.size();
  }
  EXPECT_GT(before, 0u);
}

TEST(Match, EqualDistancesAreAmbiguous) {
  FeatureGroup a = random_group(1, 3, 5), b = a;
  EXPECT_EQ(match(a, b, {}).size(), 1u);
  b.index.push_back(9);  // the same descriptor again
  b.descriptors.insert(b.descriptors.end(), a.descriptors.begin(), a.descriptors.end());
  EXPECT_TRUE(match(a, b, {}).empty());
}

TEST(Match, TiesGoToTheLowerIndex) {
  FeatureGroup a = random_group(1, 3, 6), b;
  for (std::size_t k = 0; k < 3; ++k) {
    b.index.push_back(static_cast<int>(4 + k));
    b.descriptors.insert(b.descriptors.end(), a.descriptors.begin(), a.descriptors.end());
    ++b.descriptors[k * kDescriptorSize + k];  // all three at distance 1
  }
  ++b.descriptors[std::size_t{2} * kDescriptorSize];  // the third at 2
  MatchOptions options;
  options.max_ratio = 1;
  options.mutual = false;
  // At ratio 1 an equal second is still ambiguous; from the other side the tie is broken.
  EXPECT_TRUE(match(a, b, options).empty());
  const std::vector<Match> matches =
      match(b, a, {.max_ratio = 1, .max_distance = 1, .mutual = true});
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].a, 4);
}

TEST(Match, EmptyGroupsMatchNothing) {
  const FeatureGroup some = random_group(5, 3, 7), none;
  EXPECT_TRUE(match(none, some, {}).empty());
  EXPECT_TRUE(match(some, none, {}).empty());
  EXPECT_TRUE(match(none, none, {}).empty());
}

TEST(FeaturesOfSign, SplitsWithoutLoss) {
  FeatureFrame frame;
  const FeatureGroup all = random_group(40, 20, 8);
  frame.descriptors = all.descriptors;
  for (int i = 0; i < 40; ++i) {
    Keypoint k;
    k.laplacian_sign = static_cast<std::int8_t>(i % 3 == 0 ? -1 : 1);
    frame.keypoints.push_back(k);
  }
  const FeatureGroup bright = features_of_sign(frame, -1), dark = features_of_sign(frame, 1);
  EXPECT_EQ(bright.size() + dark.size(), 40);
  for (const FeatureGroup* group : {&bright, &dark})
    for (std::size_t i = 0; i < group->index.size(); ++i) {
      const std::size_t k = static_cast<std::size_t>(group->index[i]);
      EXPECT_EQ(frame.keypoints[k].laplacian_sign, group == &bright ? -1 : 1);
      EXPECT_EQ(brute_force_distance(descriptor(*group, i), descriptor(all, k)), 0);
    }
}

TEST(MatchOptions, NameWhatIsWrong) {
  EXPECT_EQ(MatchOptions().problem(), "");
  for (const double wrong : {0.0, -1.0, 1.5, std::nan("")}) {
    MatchOptions options;
    options.max_ratio = wrong;
    EXPECT_NE(options.problem().find("max_ratio"), std::string::npos);
  }
  for (const double wrong : {0.0, -1.0, 2.5, std::nan("")}) {
    MatchOptions options;
    options.max_distance = wrong;
    EXPECT_NE(options.problem().find("max_distance"), std::string::npos);
  }
}

}  // namespace
}  // namespace eifmap
