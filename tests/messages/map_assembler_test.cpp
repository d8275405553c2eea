#include "convert/map_assembler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "messages/samples.h"

namespace eifmap {
namespace {

const Origin kOrigin{42, "cam0"};

// A whole map and 4 updates, in small parts.
std::vector<MapPart> published_parts() {
  std::vector<MapPart> all;
  for (std::int64_t i = 0; i < 5; ++i) {
    MapUpdate update = samples::map_update(2 + static_cast<int>(i), 60, i - 1, 100 * i);
    if (i == 3) update.removed_landmarks = {5, 6, 107};
    const std::vector<MapPart> parts = split_update(update, kOrigin, i, 1024);
    EXPECT_GT(parts.size(), 2u);
    all.insert(all.end(), parts.begin(), parts.end());
  }
  return all;
}

PublishedMap assembled(const std::vector<MapPart>& parts) {
  MapAssembler assembler;
  for (const MapPart& part : parts) assembler.add(part);
  EXPECT_EQ(assembler.lost_updates(), 0);
  return assembler.map();
}

void expect_same(const PublishedMap& a, const PublishedMap& b) {
  EXPECT_EQ(a.seq, b.seq);
  EXPECT_EQ(a.observed, b.observed);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  const std::vector<MapPoint> points_a = a.points(), points_b = b.points();
  ASSERT_EQ(points_a.size(), points_b.size());
  for (std::size_t i = 0; i < points_a.size(); ++i)
    EXPECT_EQ(points_a[i].position, points_b[i].position);
}

TEST(SplitUpdate, PartsFitAndHoldEverythingOnce) {
  const MapUpdate update = samples::map_update(40, 3000, -1);
  for (const std::size_t max : {kMinPartBytes, std::size_t{4096}, std::size_t{32 * 1024}}) {
    const std::vector<MapPart> parts = split_update(update, kOrigin, 0, max);
    MapUpdate sum;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      EXPECT_LE(encode(to_message(parts[i])).size(), max);
      EXPECT_EQ(parts[i].part, static_cast<int>(i));
      EXPECT_EQ(parts[i].num_parts, static_cast<int>(parts.size()));
      const MapUpdate& u = parts[i].update;
      sum.keyframes.insert(sum.keyframes.end(), u.keyframes.begin(), u.keyframes.end());
      sum.landmarks.insert(sum.landmarks.end(), u.landmarks.begin(), u.landmarks.end());
      sum.observations.insert(sum.observations.end(), u.observations.begin(), u.observations.end());
    }
    ASSERT_EQ(sum.keyframes.size(), update.keyframes.size());
    ASSERT_EQ(sum.landmarks.size(), update.landmarks.size());
    ASSERT_EQ(sum.observations.size(), update.observations.size());
    for (std::size_t i = 0; i < sum.landmarks.size(); ++i)
      EXPECT_EQ(sum.landmarks[i].id, update.landmarks[i].id);
  }
  EXPECT_THROW(split_update(update, kOrigin, 0, kMinPartBytes - 1), std::invalid_argument);
  EXPECT_EQ(split_update(MapUpdate{}, kOrigin, 0, 32768).size(), 1u);
}

TEST(MapAssembler, AnyOrderAndDuplicatesGiveTheSameMap) {
  const std::vector<MapPart> parts = published_parts();
  const PublishedMap expected = assembled(parts);
  EXPECT_EQ(expected.seq, 4);
  EXPECT_EQ(expected.keyframes.size(), 2u + 3 + 4 + 5 + 6);
  EXPECT_EQ(expected.landmarks.size(), 5 * 60u - 3);
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<MapPart> shuffled = parts;
    shuffled.insert(shuffled.end(), parts.begin(), parts.begin() + trial % 10);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    expect_same(assembled(shuffled), expected);
  }
}

TEST(MapAssembler, SaysWhatBecameOfAPart) {
  using Outcome = MapAssembler::Outcome;
  const auto whole = [](std::int64_t base) {
    return split_update(samples::map_update(1, 1, base, 10 * (base + 1)), kOrigin, 0, 32768).at(0);
  };
  MapAssembler assembler;
  EXPECT_EQ(assembler.add(whole(0)), Outcome::kWaiting) << "its base has not arrived";
  EXPECT_EQ(assembler.add(whole(-1)), Outcome::kApplied);
  EXPECT_EQ(assembler.map().seq, 1) << "the waiting one follows at once";
  EXPECT_EQ(assembler.add(whole(0)), Outcome::kIgnored) << "older than the map";
  std::vector<MapPart> parts = split_update(samples::map_update(2, 60, 1), kOrigin, 0, 1024);
  EXPECT_EQ(assembler.add(parts[0]), Outcome::kIncomplete);
  EXPECT_EQ(assembler.add(parts[0]), Outcome::kIgnored) << "a duplicate";
  MapPart contradictory = parts[1];
  ++contradictory.num_parts;
  EXPECT_EQ(assembler.add(contradictory), Outcome::kIgnored);
}

TEST(MapAssembler, LostUpdateIsCountedAndTheRestGoesOn) {
  const std::vector<MapPart> parts = published_parts();
  MapAssembler assembler;
  for (const MapPart& part : parts)
    if (!(part.update.seq == 2 && part.part == 0)) assembler.add(part);
  EXPECT_EQ(assembler.map().seq, 1) << "nothing is applied across a gap while it may still close";
  assembler.finish();
  EXPECT_EQ(assembler.map().seq, 4);
  EXPECT_GE(assembler.lost_updates(), 1);

  MapAssembler impatient(1);
  for (const MapPart& part : parts)
    if (part.update.seq != 2) impatient.add(part);
  EXPECT_EQ(impatient.map().seq, 4);
  EXPECT_EQ(impatient.lost_updates(), 1);
}

// The whole map with which an epoch begins is lost: what is known of before is in another unit.
TEST(MapAssembler, EpochsAreNeverMixed) {
  const auto part = [](std::int64_t epoch, std::int64_t base, std::int64_t first_id) {
    MapUpdate update = samples::map_update(1, 1, base, first_id);
    update.map_epoch = epoch;
    return split_update(update, kOrigin, 0, 32768).at(0);
  };
  MapAssembler assembler;
  assembler.add(part(0, -1, 0));
  assembler.add(part(0, 0, 10));
  assembler.add(part(1, 2, 30));
  assembler.add(part(1, 3, 40));
  EXPECT_EQ(assembler.map().keyframes.size(), 2u);
  assembler.finish();
  EXPECT_GE(assembler.lost_updates(), 1);
  EXPECT_EQ(assembler.map().map_epoch, 1);
  EXPECT_EQ(assembler.map().keyframes.size(), 2u);
  EXPECT_TRUE(assembler.map().keyframes.contains(30));
  EXPECT_TRUE(assembler.map().keyframes.contains(40));
}

TEST(MapAssembler, ANewMapReplacesTheOldOne) {
  MapAssembler assembler;
  const auto whole = [](std::int64_t epoch, std::int64_t map_id, std::int64_t first_id) {
    MapUpdate update = samples::map_update(1, 1, -1, first_id);
    update.map_id = map_id;
    return split_update(update, {epoch, "cam0"}, 0, 32768).at(0);
  };
  assembler.add(whole(1, 1, 0));
  assembler.add(whole(1, 2, 50));
  EXPECT_TRUE(assembler.map().keyframes.contains(50));
  EXPECT_FALSE(assembler.map().keyframes.contains(0));
  EXPECT_EQ(assembler.add(whole(1, 1, 7)), MapAssembler::Outcome::kIgnored);
  assembler.add(whole(2, 1, 70));
  EXPECT_TRUE(assembler.map().keyframes.contains(70)) << "a restarted server counts from 1 again";
}

// A map that is in use again has the number that it had, and a greater epoch than all before.
TEST(MapAssembler, AnOldMapThatIsInUseAgainReplacesTheNewerOne) {
  const auto whole = [](std::int64_t map_id, std::int64_t map_epoch, std::int64_t seq,
                        std::int64_t first_id) {
    MapUpdate update = samples::map_update(1, 1, -1, first_id);
    update.map_id = map_id;
    update.map_epoch = map_epoch;
    update.seq = seq;
    return split_update(update, kOrigin, 0, 32768).at(0);
  };
  using Outcome = MapAssembler::Outcome;
  MapAssembler assembler;
  EXPECT_EQ(assembler.add(whole(1, 0, 7, 0)), Outcome::kApplied);
  EXPECT_EQ(assembler.add(whole(2, 1, 3, 50)), Outcome::kApplied) << "a new map counts from 0";
  EXPECT_EQ(assembler.add(whole(1, 0, 8, 0)), Outcome::kIgnored) << "said before that";
  EXPECT_EQ(assembler.map().map_id, 2);
  EXPECT_EQ(assembler.add(whole(1, 2, 8, 10)), Outcome::kApplied);
  EXPECT_EQ(assembler.map().map_id, 1);
  EXPECT_TRUE(assembler.map().keyframes.contains(10));
  EXPECT_FALSE(assembler.map().keyframes.contains(50));
  EXPECT_EQ(assembler.add(whole(2, 1, 4, 50)), Outcome::kIgnored) << "said before that";
  EXPECT_EQ(assembler.map().map_id, 1);
  EXPECT_EQ(assembler.map().map_epoch, 2);
}

// Parts of the map that is in use again are there, but not all of them.
TEST(MapAssembler, WhatComesLateDoesNotUndoANewEpoch) {
  MapUpdate again = samples::map_update(2, 200, -1, 10);
  again.map_epoch = 2;
  again.seq = 8;
  const std::vector<MapPart> parts = split_update(again, kOrigin, 0, 2048);
  ASSERT_GT(parts.size(), 1u);
  MapUpdate late = samples::map_update(1, 1, -1, 50);
  late.map_id = 2;
  late.map_epoch = 1;
  MapAssembler assembler;
  assembler.add(split_update(samples::map_update(1, 1, -1), kOrigin, 0, 32768).at(0));
  assembler.add(parts[0]);
  EXPECT_EQ(assembler.add(split_update(late, kOrigin, 0, 32768).at(0)),
            MapAssembler::Outcome::kIgnored);
  for (std::size_t i = 1; i < parts.size(); ++i) assembler.add(parts[i]);
  EXPECT_EQ(assembler.map().map_id, 1);
  EXPECT_EQ(assembler.map().map_epoch, 2);
  EXPECT_EQ(assembler.lost_updates(), 0);
}

}  // namespace
}  // namespace eifmap
