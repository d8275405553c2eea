#include "place/place_index.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "place/random_frame.h"

namespace eifmap {

bool operator==(const PlaceScore& a, const PlaceScore& b) {
  return a.id == b.id && a.score == b.score;
}

namespace test {
namespace {

using Places = std::vector<PlaceScore>;

PlaceIndex index_of(int images, const PlaceOptions& options = {}) {
  PlaceIndex index(options);
  for (int i = 0; i < images; ++i) index.add(i, random_frame(static_cast<std::uint64_t>(i)));
  return index;
}

FeatureFrame again(int image) {
  const auto seed = static_cast<std::uint64_t>(image);
  return seen_again(random_frame(seed), 1000 + seed);
}

TEST(PlaceIndex, KnowsWhatItHasSeen) {
  const PlaceIndex index = index_of(60);
  ASSERT_TRUE(index.ready());
  EXPECT_EQ(index.size(), 60);
  for (int i = 0; i < 60; ++i) {
    const Places same = index.query(random_frame(static_cast<std::uint64_t>(i)), 2);
    ASSERT_EQ(same.size(), 2u);
    EXPECT_EQ(same[0].id, i);
    EXPECT_NEAR(same[0].score, 1, 0.03);
    EXPECT_LT(same[1].score, 0.75);
    EXPECT_EQ(index.query(again(i), 1).front().id, i);
  }
}

TEST(PlaceIndex, IsReadyOnceItHasLearnt) {
  PlaceOptions options;
  options.learn_from = 4;
  PlaceIndex index(options);
  for (int i = 0; i < 4; ++i) {
    EXPECT_FALSE(index.ready());
    EXPECT_TRUE(index.query(random_frame(0), 5).empty());
    index.add(10 + i, random_frame(static_cast<std::uint64_t>(i)));
    EXPECT_TRUE(index.contains(10 + i));
    EXPECT_FALSE(index.contains(i));
  }
  EXPECT_TRUE(index.ready());
  EXPECT_EQ(index.query(random_frame(2), 1).front().id, 12);  // also what it has learnt from
}

TEST(PlaceIndex, OrdersByScoreThenId) {
  PlaceIndex index = index_of(20);
  index.remove(3);
  index.add(31, random_frame(3));
  index.add(30, random_frame(3));
  const Places found = index.query(again(3), 100);
  ASSERT_EQ(found.size(), 21u);
  EXPECT_EQ(found[0].id, 30);
  EXPECT_EQ(found[1].id, 31);
  EXPECT_EQ(found[0].score, found[1].score);
  for (std::size_t i = 1; i < found.size(); ++i) EXPECT_GE(found[i - 1].score, found[i].score);
  EXPECT_TRUE(index.query(again(3), 0).empty());
}

TEST(PlaceIndex, SaysTheSameTwice) {
  const PlaceIndex a = index_of(40), b = index_of(40);
  PlaceOptions other;
  other.seed = 2;
  const PlaceIndex c = index_of(40, other);
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(a.query(again(i), 40), b.query(again(i), 40));
    EXPECT_NE(a.query(again(i), 40), c.query(again(i), 40));
  }
}

// Slots are used again; nobody can tell.
TEST(PlaceIndex, ARemovedImageIsAsIfItHadNeverBeen) {
  PlaceIndex index = index_of(30), plain = index_of(10);
  for (const int i : {12, 29, 17, 5, 10}) {
    index.remove(i);
    EXPECT_FALSE(index.contains(i));
  }
  plain.remove(5);
  for (int i = 40; i < 43; ++i) index.add(i, random_frame(static_cast<std::uint64_t>(i)));
  for (int i = 40; i < 43; ++i) plain.add(i, random_frame(static_cast<std::uint64_t>(i)));
  for (int i = 29; i > 10; --i)
    if (index.contains(i)) plain.add(i, random_frame(static_cast<std::uint64_t>(i)));
  EXPECT_EQ(index.size(), 28);
  for (int i = 0; i < 43; ++i) EXPECT_EQ(index.query(again(i), 50), plain.query(again(i), 50));
}

TEST(PlaceIndex, WhatIsRemovedBeforeItHasLearntIsNotLearntFrom) {
  PlaceOptions options;
  options.learn_from = 3;
  PlaceIndex index(options), plain(options);
  index.add(7, random_frame(7));
  index.remove(7);
  EXPECT_FALSE(index.contains(7));
  EXPECT_EQ(index.size(), 0);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(index.ready());
    index.add(i, random_frame(static_cast<std::uint64_t>(i)));
    plain.add(i, random_frame(static_cast<std::uint64_t>(i)));
  }
  EXPECT_EQ(index.query(again(1), 5), plain.query(again(1), 5));
}

TEST(PlaceIndex, CopiesGoTheirOwnWays) {
  for (const int images : {5, 30}) {  // before and after it has learnt
    PlaceIndex index = index_of(images);
    const PlaceIndex before = index;
    const Places said = before.query(again(2), 50);
    PlaceIndex other = index;
    index.remove(2);
    index.add(50, random_frame(50));
    for (int i = 60; i < 70; ++i) other.add(i, random_frame(2));
    EXPECT_EQ(before.query(again(2), 50), said);
    EXPECT_EQ(before.size(), images);
    EXPECT_TRUE(before.contains(2));
    EXPECT_FALSE(before.contains(50));
    EXPECT_FALSE(index.contains(2));
    EXPECT_FALSE(other.contains(50));
    EXPECT_EQ(other.size(), images + 10);
  }
}

TEST(PlaceIndex, RefusesMisuseAndStaysAsItWas) {
  PlaceOptions none, backwards;
  none.learn_from = 0;
  backwards.iterations = -1;
  EXPECT_THROW(PlaceIndex{none}, std::invalid_argument);
  EXPECT_THROW(PlaceIndex{backwards}, std::invalid_argument);
  FeatureFrame broken = random_frame(1);
  broken.descriptors.pop_back();
  for (const int images : {5, 30}) {
    PlaceIndex index = index_of(images);
    const Places said = index.query(again(2), 50);
    EXPECT_THROW(index.add(2, random_frame(2)), std::invalid_argument);
    EXPECT_THROW(index.add(-1, random_frame(2)), std::invalid_argument);
    EXPECT_THROW(index.add(90, broken), std::invalid_argument);
    EXPECT_THROW(index.remove(90), std::invalid_argument);
    EXPECT_THROW(index.remove(-1), std::invalid_argument);
    EXPECT_THROW(index.query(random_frame(1), -1), std::invalid_argument);
    EXPECT_THROW(index.query(broken, 1), std::invalid_argument);
    EXPECT_FALSE(index.contains(-1));
    EXPECT_EQ(index.size(), images);
    EXPECT_EQ(index.query(again(2), 50), said);
    index.remove(2);
    EXPECT_THROW(index.remove(2), std::invalid_argument);
    EXPECT_FALSE(index.contains(-1));
  }
}

// A camera in the dark, and one that sees blobs of one sign alone.
TEST(PlaceIndex, ImagesOfNothingAreLikeNothing) {
  PlaceIndex index;
  for (int i = 0; i < 10; ++i) index.add(i, FeatureFrame());
  EXPECT_TRUE(index.ready());
  for (const PlaceScore& place : index.query(random_frame(1), 10)) EXPECT_EQ(place.score, 0);

  PlaceIndex other = index_of(20);
  other.add(20, FeatureFrame());
  FeatureFrame half = random_frame(4);
  for (Keypoint& keypoint : half.keypoints) keypoint.laplacian_sign = 1;
  other.add(21, half);
  EXPECT_EQ(other.query(half, 1).front().id, 21);
  for (const PlaceScore& place : other.query(FeatureFrame(), 30)) EXPECT_EQ(place.score, 0);
}

}  // namespace
}  // namespace test
}  // namespace eifmap
