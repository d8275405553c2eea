#include "place/words.h"

#include <gtest/gtest.h>

#include <set>

#include "features/matcher.h"
#include "place/random_frame.h"
#include "place/signature.h"

namespace eifmap::test {
namespace {

// Descriptors about so many others, `each` around one.
std::vector<std::int8_t> clusters(const std::vector<std::int8_t>& middles, int each, double noise) {
  Random random(5);
  std::vector<std::int8_t> descriptors;
  for (int i = 0; i < each; ++i)
    for (const std::int8_t byte : middles)
      descriptors.push_back(static_cast<std::int8_t>(
          std::clamp(std::lround(byte + noise * random.normal()), -127l, 127l)));
  return descriptors;
}

TEST(Words, FindWhatThereIs) {
  const auto middles = random_descriptors(1, kWordsPerSign);
  const auto descriptors = clusters(middles, 20, 3);
  const Words chosen = learn_words(descriptors, 0, 1), moved = learn_words(descriptors, 1, 1);
  ASSERT_EQ(chosen.size(), static_cast<std::size_t>(kWordsPerSign) * kDescriptorSize);
  std::set<int> found;
  std::int64_t off_chosen = 0, off_moved = 0;
  for (int k = 0; k < kWordsPerSign; ++k) {
    const std::int8_t* middle = &middles[static_cast<std::size_t>(k) * kDescriptorSize];
    const int a = nearest_word(middle, chosen), b = nearest_word(middle, moved);
    found.insert(a);
    off_chosen +=
        descriptor_distance(middle, &chosen[static_cast<std::size_t>(a) * kDescriptorSize]);
    off_moved += descriptor_distance(middle, &moved[static_cast<std::size_t>(b) * kDescriptorSize]);
  }
  // Drawn by distance, hardly any of 32 heaps is hit twice; drawn evenly it would be 20 of them.
  EXPECT_GE(found.size(), 29u);
  EXPECT_LT(off_moved, off_chosen / 2);
}

TEST(Words, AreTheSameEveryTimeAndNotWithAnotherSeed) {
  const auto descriptors = random_descriptors(2, 500);
  EXPECT_EQ(learn_words(descriptors, 1, 1), learn_words(descriptors, 1, 1));
  EXPECT_NE(learn_words(descriptors, 1, 1), learn_words(descriptors, 1, 2));
}

TEST(Words, OfLittleAndOfNothing) {
  EXPECT_TRUE(learn_words({}, 1, 1).empty());
  const auto two = random_descriptors(3, 2);
  const Words words = learn_words(two, 1, 1);
  for (const std::size_t i : {0, 1}) {
    const std::int8_t* descriptor = &two[i * kDescriptorSize];
    const auto word = static_cast<std::size_t>(nearest_word(descriptor, words));
    EXPECT_EQ(descriptor_distance(descriptor, &words[word * kDescriptorSize]), 0);
  }
}

// Of two words 2 apart, one descriptor at the first's side by 1: sums, roots and scale by hand.
TEST(Signature, IsWhatItIsDefinedToBe) {
  SplitWords words;
  words.plus.assign(static_cast<std::size_t>(kWordsPerSign) * kDescriptorSize, 100);
  std::fill_n(words.plus.begin(), kDescriptorSize, 0);
  SplitFeatures features;
  features.plus.index = {0, 1};
  features.plus.descriptors.assign(2ul * kDescriptorSize, 0);
  features.plus.descriptors[0] = 9;
  features.plus.descriptors[1] = -3;
  features.plus.descriptors[kDescriptorSize] = 7;
  features.plus.descriptors[kDescriptorSize + 2] = 101;
  // Sums 16, -3, 101, of which the roots are 4, 1.73, 10.05; the length's square is 120.
  Signature expected{};
  std::int8_t* plus = expected.data() + kSignatureSize / 2;
  plus[0] = 127;  // 146
  plus[1] = -63;
  plus[2] = 127;  // 367
  EXPECT_EQ(describe(features, words), expected);
  EXPECT_EQ(similarity(expected, expected), 127 * 127 * 2 + 63 * 63);
  EXPECT_EQ(describe({}, words), Signature{});
  EXPECT_EQ(describe(features, {}), Signature{});
}

TEST(Signature, SimilarityIsTheInnerProduct) {
  Random random(4);
  Signature a, b;
  std::int64_t expected = 0;
  for (std::size_t i = 0; i < kSignatureSize; ++i) {
    a[i] = static_cast<std::int8_t>(static_cast<int>(random.bits() % 255) - 127);
    b[i] = static_cast<std::int8_t>(static_cast<int>(random.bits() % 255) - 127);
    expected += a[i] * b[i];
  }
  EXPECT_EQ(similarity(a, b), expected);
  a.fill(-127), b.fill(127);
  EXPECT_EQ(similarity(a, b), -127 * 127 * static_cast<int>(kSignatureSize));
}

}  // namespace
}  // namespace eifmap::test
