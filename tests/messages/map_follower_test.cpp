#include "published/map_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "messages/samples.h"

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using Outcome = MapFollower::Outcome;
using TimePoint = MapFollower::TimePoint;

const TimePoint kStart{1h};

// What a server publishes, with digests, and its parts.
class Publishing {
 public:
  explicit Publishing(std::int64_t server_epoch = 42) : server_epoch_(server_epoch) {}

  std::vector<map_part_t> next(bool whole, int landmarks = 60) {
    MapUpdate update = samples::map_update(2, landmarks, map_.seq(), 100 * map_.seq());
    update.seq = map_.seq() + 1;
    update.base_seq = whole ? -1 : map_.seq();
    map_part_t message = to_message(update, {server_epoch_, "cam0"}, 7);
    map_.apply(message);
    message.digest = map_.digest();
    return split(message, 1024);
  }
  const PublishedMap& map() const { return map_; }

 private:
  std::int64_t server_epoch_;
  PublishedMap map_;
};

Outcome take_all(MapFollower& follower, const std::vector<map_part_t>& parts,
                 TimePoint now = kStart) {
  Outcome last = Outcome::kIgnored;
  for (const map_part_t& part : parts) last = follower.take(part, now);
  return last;
}

void expect_same(const MapFollower& follower, const PublishedMap& map) {
  EXPECT_FALSE(follower.is_stale());
  EXPECT_EQ(encode(follower.map().whole()), encode(map.whole()));
}

TEST(MapFollower, AnyOrderAndDuplicatesGiveTheSameMap) {
  Publishing server;
  std::vector<map_part_t> all;
  for (int i = 0; i < 5; ++i) {
    const auto parts = server.next(i == 0);
    ASSERT_GT(parts.size(), 2u);
    all.insert(all.end(), parts.begin(), parts.end());
  }
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<map_part_t> shuffled = all;
    shuffled.insert(shuffled.end(), all.begin(), all.begin() + trial % 10);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    MapFollower follower(1);
    take_all(follower, shuffled);
    expect_same(follower, server.map());
  }
}

TEST(MapFollower, AppliesNothingAcrossAGapAndAsksForJustThat) {
  Publishing server;
  MapFollower follower(5);
  take_all(follower, server.next(true));
  const auto second = server.next(false), third = server.next(false);
  for (const map_part_t& part : second)
    if (part.part != 1) follower.take(part, kStart);
  take_all(follower, third);
  EXPECT_EQ(follower.map().seq(), 1);
  EXPECT_TRUE(follower.is_stale());
  EXPECT_FALSE(follower.ask(kStart + 50ms, 0)) << "it may still come";
  const auto request = follower.ask(kStart + 100ms, 9);
  ASSERT_TRUE(request);
  EXPECT_TRUE(decode_map_request(encode(*request)).ok());
  EXPECT_EQ(request->utime, 9);
  EXPECT_EQ(request->requester, 5);
  EXPECT_EQ(request->have_seq, 1);
  EXPECT_EQ(request->server_epoch, 42);
  ASSERT_EQ(request->missing.size(), 1u);
  EXPECT_EQ(request->missing[0].seq, 2);
  EXPECT_EQ(request->missing[0].part, 1);
  EXPECT_FALSE(follower.ask(kStart + 150ms, 0)) << "patience";
  EXPECT_TRUE(follower.ask(kStart + 200ms, 0));
  EXPECT_FALSE(follower.ask(kStart + 350ms, 0)) << "ever more of it";
  EXPECT_EQ(follower.take(second[1], kStart + 360ms), Outcome::kApplied);
  expect_same(follower, server.map());
  EXPECT_FALSE(follower.ask(kStart + 1h, 0));
}

TEST(MapFollower, LearnsFromPosesThatTheLastUpdateIsMissing) {
  Publishing server;
  MapFollower follower(1);
  take_all(follower, server.next(true));
  server.next(false);
  EXPECT_FALSE(follower.is_stale());
  follower.hear("cam0", 42, server.map().seq(), kStart);
  const auto request = follower.ask(kStart + 100ms, 0);
  ASSERT_TRUE(request);
  ASSERT_EQ(request->missing.size(), 1u);
  EXPECT_EQ(request->missing[0].seq, 2);
  EXPECT_EQ(request->missing[0].part, kAllParts);
}

TEST(MapFollower, ComesLateAndAsksForTheWholeMap) {
  Publishing server;
  MapFollower follower(1);
  EXPECT_FALSE(follower.is_stale());
  follower.hear("cam0", 42, 0, kStart);
  EXPECT_FALSE(follower.ask(kStart + 1h, 0)) << "there is no map yet";
  server.next(true);
  take_all(follower, server.next(false));
  const auto request = follower.ask(kStart + 100ms, 0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->have_seq, -1);
  EXPECT_TRUE(request->missing.empty());

  map_part_t whole = server.map().whole();
  std::vector<map_part_t> parts = split(whole, 1024);
  ASSERT_GT(parts.size(), 3u);
  const map_part_t lost = parts[1];
  parts.erase(parts.begin() + 1);
  take_all(follower, parts, kStart + 200ms);
  const auto more = follower.ask(kStart + 300ms, 0);
  ASSERT_TRUE(more);
  ASSERT_EQ(more->missing.size(), 1u);
  EXPECT_EQ(more->missing[0].seq, 2);
  EXPECT_EQ(more->missing[0].part, 1);
  EXPECT_EQ(more->missing[0].whole, 1);
  EXPECT_EQ(follower.take(lost, kStart + 300ms), Outcome::kApplied);
  expect_same(follower, server.map());
}

// The server has the steps no more, and answers with a whole map, of which a part is lost.
TEST(MapFollower, GoesByTheWholeMapWhereStepsDoNotCome) {
  Publishing server;
  MapFollower follower(1);
  take_all(follower, server.next(true));
  server.next(false);
  server.next(false);
  follower.hear("cam0", 42, 3, kStart);
  ASSERT_TRUE(follower.ask(kStart + 100ms, 0));
  std::vector<map_part_t> parts = split(server.map().whole(), 1024);
  for (std::size_t i = 1; i < parts.size(); ++i) follower.take(parts[i], kStart + 110ms);
  const auto request = follower.ask(kStart + 400ms, 0);
  ASSERT_TRUE(request);
  ASSERT_EQ(request->missing.size(), 1u);
  EXPECT_EQ(request->missing[0].whole, 1);
  EXPECT_EQ(request->missing[0].part, 0);
  EXPECT_EQ(follower.take(parts[0], kStart + 410ms), Outcome::kApplied);
  expect_same(follower, server.map());
}

TEST(MapFollower, AMapThatIsNotWhatWasPublishedIsAskedForAnew) {
  Publishing server;
  MapFollower follower(1);
  std::vector<map_part_t> parts = server.next(true, 3);
  ASSERT_EQ(parts.size(), 1u);
  map_part_t wrong = parts[0];
  wrong.landmarks[0].position[0] += 1;
  EXPECT_EQ(follower.take(wrong, kStart), Outcome::kApplied);
  EXPECT_TRUE(follower.is_stale());
  EXPECT_EQ(follower.counts().wrong_digests, 1);
  const auto request = follower.ask(kStart + 200ms, 0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->have_seq, -1);
  EXPECT_EQ(follower.take(parts[0], kStart + 300ms), Outcome::kApplied);
  expect_same(follower, server.map());

  follower.hear("cam0", 42, 1, kStart + 400ms, server.map().digest() + 1);
  EXPECT_TRUE(follower.is_stale()) << "a status says otherwise";
}

TEST(MapFollower, AnotherRunOfTheServerReplacesTheMap) {
  Publishing old(1), restarted(2);
  MapFollower follower(1);
  take_all(follower, old.next(true));
  take_all(follower, old.next(false));
  follower.hear("cam0", 2, 0, kStart);
  EXPECT_TRUE(follower.is_stale());
  EXPECT_FALSE(follower.ask(kStart + 1h, 0)) << "the new run has no map yet";
  const auto first = restarted.next(true);
  follower.take(first[0], kStart);
  EXPECT_EQ(follower.map().server_epoch(), 1) << "until the new one is whole";
  EXPECT_TRUE(follower.is_stale());
  EXPECT_EQ(take_all(follower, old.next(false)), Outcome::kIgnored);
  take_all(follower, first);
  expect_same(follower, restarted.map());
}

TEST(MapFollower, SaysWhatBecameOfAPart) {
  Publishing server;
  MapFollower follower(1);
  const auto first = server.next(true), second = server.next(false), third = server.next(false);
  EXPECT_EQ(take_all(follower, second), Outcome::kIncomplete) << "its base has not arrived";
  EXPECT_EQ(take_all(follower, first), Outcome::kApplied);
  EXPECT_EQ(follower.map().seq(), 2) << "the waiting one follows at once";
  EXPECT_EQ(follower.take(second[0], kStart), Outcome::kIgnored) << "older than the map";
  EXPECT_EQ(follower.take(third[0], kStart), Outcome::kIncomplete);
  EXPECT_EQ(follower.take(third[0], kStart), Outcome::kIgnored) << "a duplicate";
  map_part_t contradictory = third[1];
  ++contradictory.num_parts;
  EXPECT_EQ(follower.take(contradictory, kStart), Outcome::kIgnored);
  contradictory = third[1];
  ++contradictory.digest;
  EXPECT_EQ(follower.take(contradictory, kStart), Outcome::kIgnored);
  EXPECT_EQ(follower.counts().contradictions, 2);
}

TEST(MapFollower, TellsWhatChanged) {
  Publishing server;
  MapFollower follower(1);
  take_all(follower, server.next(true, 60));
  MapChange change = follower.take_changes();
  EXPECT_TRUE(change.whole);
  EXPECT_EQ(change.keyframes, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(change.landmarks.size(), 120u) << "each, and each seen";
  take_all(follower, server.next(false, 1));
  change = follower.take_changes();
  EXPECT_FALSE(change.whole);
  EXPECT_EQ(change.keyframes, (std::vector<std::int64_t>{100, 101}));
  EXPECT_TRUE(follower.take_changes().keyframes.empty());
}

TEST(MapFollower, WhatWaitsIsBounded) {
  Publishing server;
  MapFollower follower(1);
  take_all(follower, server.next(true, 1));
  const auto missing = server.next(false, 1);
  for (int i = 0; i < 3000; ++i) take_all(follower, server.next(false, 1));
  EXPECT_EQ(follower.map().seq(), 1);
  take_all(follower, missing);
  EXPECT_EQ(follower.map().seq(), 2 + static_cast<std::int64_t>(MapFollower::kMaxWaiting));
  EXPECT_TRUE(follower.is_stale());
  const auto request = follower.ask(kStart + 1h, 0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->missing.size(), kMaxMissing);
  EXPECT_TRUE(decode_map_request(encode(*request)).ok());
}

}  // namespace
}  // namespace eifmap
