#include "published/published_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "messages/samples.h"
#include "published/map_digest.h"
#include "published/map_part.h"

namespace eifmap {
namespace {

const Origin kOrigin{42, "cam0"};

map_part_t sample(int keyframes, int landmarks, std::int64_t base_seq, std::int64_t first_id = 0) {
  return to_message(samples::map_update(keyframes, landmarks, base_seq, first_id), kOrigin, 7);
}

observation_t observation(std::int64_t keyframe, std::int64_t landmark, float u, float v) {
  observation_t o;
  o.keyframe = keyframe;
  o.landmark = landmark;
  o.u = u;
  o.v = v;
  return o;
}

TEST(SplitMapUpdate, PartsFitAndHoldEverythingOnce) {
  const map_part_t update = sample(40, 3000, -1);
  for (const std::size_t max : {kMinPartBytes, std::size_t{4096}, std::size_t{32 * 1024}}) {
    const std::vector<map_part_t> parts = split(update, max);
    map_part_t sum = update;
    sum.keyframes.clear();
    sum.landmarks.clear();
    sum.observations.clear();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      EXPECT_LE(encode(parts[i]).size(), max);
      EXPECT_EQ(parts[i].part, static_cast<int>(i));
      EXPECT_EQ(parts[i].num_parts, static_cast<int>(parts.size()));
      append(parts[i], sum);
    }
    EXPECT_EQ(encode(sum), encode(update));
  }
  EXPECT_THROW(split(update, kMinPartBytes - 1), std::invalid_argument);
  EXPECT_EQ(split(sample(1, 0, -1), 32768).size(), 1u);
}

TEST(PublishedMap, TakesUpdatesOver) {
  PublishedMap map;
  map.apply(sample(3, 10, -1));
  EXPECT_EQ(map.keyframes().size(), 3u);
  EXPECT_EQ(map.landmarks().size(), 10u);
  EXPECT_EQ(map.num_observations(), 10);
  EXPECT_EQ(map.landmarks().at(4).observations.at(0).keyframe, 1);

  map_part_t update = sample(0, 0, 1);
  update.removed = {3, 99};
  update.observations = {observation(2, 4, 5, 6), observation(0, 4, 7, 8),
                         observation(1, 4, NAN, NAN), observation(1, 1000, 1, 1)};
  map.apply(update);
  EXPECT_EQ(map.landmarks().size(), 9u);
  EXPECT_FALSE(map.landmarks().contains(3));
  const auto& seen = map.landmarks().at(4).observations;
  ASSERT_EQ(seen.size(), 2u) << "by keyframe, without the one that is gone";
  EXPECT_EQ(seen[0].keyframe, 0);
  EXPECT_EQ(seen[1].keyframe, 2);
  EXPECT_EQ(map.num_observations(), 10);
  EXPECT_EQ(map.seq(), 2);

  map.apply(sample(1, 1, -1, 70));
  EXPECT_EQ(map.keyframes().size(), 1u);
  EXPECT_EQ(map.landmarks().size(), 1u);
}

TEST(PublishedMap, DigestIsOfTheContentsAndOfNothingElse) {
  PublishedMap map, backwards;
  map_part_t update = sample(5, 40, -1);
  map.apply(update);
  std::reverse(update.keyframes.begin(), update.keyframes.end());
  std::reverse(update.landmarks.begin(), update.landmarks.end());
  std::reverse(update.observations.begin(), update.observations.end());
  update.seq = 77;
  backwards.apply(update);
  EXPECT_EQ(map.digest(), backwards.digest());
  EXPECT_NE(map.digest(), 0);

  PublishedMap again;
  again.apply(map.whole());
  EXPECT_EQ(again.digest(), map.digest());
  EXPECT_EQ(encode(again.whole()), encode(map.whole()));

  // Everything that is gone again has left nothing.
  map_part_t more = sample(1, 3, 1, 1000);
  more.keyframes.clear();
  const std::int64_t before = map.digest();
  map.apply(more);
  EXPECT_NE(map.digest(), before);
  map_part_t less = sample(0, 0, 2);
  less.removed = {1000, 1001, 1002};
  map.apply(less);
  EXPECT_EQ(map.digest(), before);
}

// Each value of each entry is in it.
TEST(PublishedMap, DigestTellsEveryValue) {
  const map_part_t update = sample(2, 2, -1);
  PublishedMap map;
  map.apply(update);
  const auto differs = [&](auto change) {
    map_part_t other = update;
    change(other);
    PublishedMap changed;
    changed.apply(other);
    return changed.digest() != map.digest();
  };
  EXPECT_FALSE(differs([](map_part_t&) {}));
  EXPECT_TRUE(differs([](map_part_t& u) { u.keyframes[1].utime += 1; }));
  EXPECT_TRUE(differs([](map_part_t& u) { u.keyframes[1].position[2] += 1e-12; }));
  EXPECT_TRUE(differs([](map_part_t& u) { u.keyframes[1].covariance[20] += 1; }));
  EXPECT_TRUE(differs([](map_part_t& u) { u.landmarks[1].anchor = 0; }));
  EXPECT_TRUE(differs([](map_part_t& u) { u.landmarks[1].laplacian_sign *= -1; }));
  EXPECT_TRUE(differs([](map_part_t& u) { u.observations[1].v += 1; }));
  EXPECT_TRUE(differs([](map_part_t& u) { std::swap(u.landmarks[0].id, u.landmarks[1].id); }));
}

// What other languages compute, too (messages/README.md).
TEST(MapDigest, IsWhatTheReadmeSays) {
  observation_t o = observation(1, 2, 0.5f, -3);
  const std::vector<std::uint8_t> bytes{0, 0, 0, 0, 0,    0, 0, 1, 0,    0,    0, 0,
                                        0, 0, 0, 2, 0x3f, 0, 0, 0, 0xc0, 0x40, 0, 0};
  std::uint64_t h = (0xcbf29ce484222325 ^ 'O') * 0x100000001b3;
  for (const std::uint8_t byte : bytes) h = (h ^ byte) * 0x100000001b3;
  h = (h ^ h >> 33) * 0xff51afd7ed558ccd;
  h = (h ^ h >> 33) * 0xc4ceb9fe1a85ec53;
  EXPECT_EQ(entry_hash(o), h ^ h >> 33);
}

TEST(PositionInMap, IsTheAnchorsTimesTheLandmarks) {
  PublishedMap map;
  const MapUpdate update = samples::map_update(4, 20, -1);
  map.apply(to_message(update, kOrigin, 7));
  for (const LandmarkView& l : update.landmarks) {
    Eigen::Vector3d position;
    ASSERT_TRUE(position_in_map(map, map.landmarks().at(l.id).value, position.data()));
    const Eigen::Vector3d expected =
        update.keyframes[static_cast<std::size_t>(l.anchor)].map_from_camera * l.position_in_anchor;
    EXPECT_LT((position - expected).norm(), 1e-12);
  }
  landmark_t lost = map.landmarks().at(0).value;
  lost.anchor = 1000;
  double position[3];
  EXPECT_FALSE(position_in_map(map, lost, position));
}

}  // namespace
}  // namespace eifmap
