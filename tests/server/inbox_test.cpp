#include "server/inbox.h"

#include <gtest/gtest.h>

#include <thread>

namespace eifmap {
namespace {

using std::chrono::steady_clock;
constexpr std::chrono::seconds kLong(30);

const Channel kImage{"a", ChannelKind::kImage};
const Channel kCalibration{"a", ChannelKind::kCalibration};

void put(Inbox& inbox, const Channel& channel, std::uint8_t value, std::size_t size = 1) {
  const std::vector<std::uint8_t> bytes(size, value);
  inbox.put(channel, bytes);
}

// What waits, without waiting for more.
std::optional<Received> take(Inbox& inbox) {
  return inbox.take(steady_clock::now());
}

TEST(InboxNewest, NewFrameReplacesTheWaitingOne) {
  Inbox inbox(InputMode::kNewest, 1000);
  for (std::uint8_t i = 0; i < 5; ++i) put(inbox, kImage, i);
  const std::optional<Received> taken = take(inbox);
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->bytes[0], 4);
  EXPECT_EQ(taken->dropped_before, 4);
  EXPECT_FALSE(take(inbox));
  EXPECT_EQ(inbox.counts().frames, 5);
  EXPECT_EQ(inbox.counts().dropped, 4);
  put(inbox, kImage, 9);
  EXPECT_EQ(take(inbox)->dropped_before, 0);
}

TEST(InboxNewest, FeaturesReplaceImages) {
  Inbox inbox(InputMode::kNewest, 1000);
  put(inbox, kImage, 1);
  put(inbox, {"a", ChannelKind::kFeatures}, 3);
  EXPECT_EQ(take(inbox)->bytes[0], 3);
  EXPECT_FALSE(take(inbox));
}

TEST(InboxNewest, CalibrationIsKeptAndInOrder) {
  Inbox inbox(InputMode::kNewest, 1000);
  put(inbox, kCalibration, 1);
  put(inbox, kImage, 2);
  put(inbox, kImage, 3);
  EXPECT_EQ(take(inbox)->channel, kCalibration);
  EXPECT_EQ(take(inbox)->bytes[0], 3);
}

TEST(InboxNewest, EveryMeasurementIsKeptInItsPlace) {
  Inbox inbox(InputMode::kNewest, 5);
  const Channel measurement{"a", ChannelKind::kMeasurement};
  put(inbox, measurement, 1);
  put(inbox, kImage, 2);
  put(inbox, measurement, 3);
  put(inbox, kImage, 4);
  put(inbox, measurement, 5);
  put(inbox, measurement, 6);
  put(inbox, measurement, 7);
  for (const int expected : {1, 3, 4, 5, 6}) EXPECT_EQ(take(inbox)->bytes[0], expected);
  EXPECT_FALSE(take(inbox));
  EXPECT_EQ(inbox.counts().frames, 2);
  EXPECT_EQ(inbox.counts().dropped, 1);
  EXPECT_EQ(inbox.counts().measurements_dropped, 1) << "there was no room for the last";
}

TEST(InboxLossless, KeepsEveryFrameInOrder) {
  Inbox inbox(InputMode::kLossless, 1000);
  for (std::uint8_t i = 0; i < 100; ++i) put(inbox, kImage, i);
  for (std::uint8_t i = 0; i < 100; ++i) EXPECT_EQ(take(inbox)->bytes[0], i);
  EXPECT_EQ(inbox.counts().dropped, 0);
}

TEST(InboxLossless, FullInboxHoldsTheReceiverBackAndLosesNothing) {
  Inbox inbox(InputMode::kLossless, 10);
  constexpr int kMessages = 500;
  std::thread receiver([&] {
    for (int i = 0; i < kMessages; ++i) put(inbox, kImage, static_cast<std::uint8_t>(i), 4);
  });
  for (int i = 0; i < kMessages; ++i) {
    const std::optional<Received> taken = inbox.take(steady_clock::now() + kLong);
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->bytes[0], static_cast<std::uint8_t>(i));
    // 10 bytes hold two messages: the receiver can be at most that far ahead.
    EXPECT_LE(inbox.counts().frames, i + 1 + 2);
  }
  receiver.join();
}

TEST(InboxLossless, CloseFreesAWaitingReceiver) {
  Inbox inbox(InputMode::kLossless, 1);
  put(inbox, kImage, 1);
  std::thread receiver([&] { put(inbox, kImage, 2); });
  inbox.close();
  receiver.join();
  EXPECT_FALSE(inbox.take(steady_clock::now() + kLong)) << "closed: nothing more comes out";
}

TEST(Inbox, IdleOnlyWhenTheTakerCameBack) {
  Inbox inbox(InputMode::kNewest, 1000);
  put(inbox, kImage, 1);
  EXPECT_FALSE(inbox.wait_until_idle(steady_clock::now()));
  take(inbox);
  EXPECT_FALSE(inbox.wait_until_idle(steady_clock::now())) << "the message is in work";
  take(inbox);
  EXPECT_TRUE(inbox.wait_until_idle(steady_clock::now()));
}

// The taker that gives up an incomplete frame while the inbox is full must not wait for itself.
TEST(Inbox, WhoMayNotWaitDropsInstead) {
  Inbox inbox(InputMode::kLossless, 100);
  const std::vector<std::uint8_t> bytes(80);
  const Channel channel{"cam0", ChannelKind::kFeatures};
  inbox.put(channel, bytes);
  inbox.put(channel, bytes, /*may_wait=*/false);
  EXPECT_EQ(inbox.counts().frames, 2);
  EXPECT_EQ(inbox.counts().dropped, 1);
  EXPECT_TRUE(inbox.take(std::chrono::steady_clock::now()));
  inbox.put(channel, bytes, /*may_wait=*/false);
  EXPECT_EQ(inbox.counts().dropped, 1);
}

// A loss is counted between the frames it lies between, not before those that waited already.
TEST(InboxLossless, WhatHadNoRoomIsMissingBeforeTheNext) {
  Inbox inbox(InputMode::kLossless, 10);
  const std::vector<std::uint8_t> bytes(5);
  for (int i = 0; i < 5; ++i) inbox.put(kImage, bytes, /*may_wait=*/false);
  EXPECT_EQ(inbox.counts().dropped, 3);
  EXPECT_EQ(take(inbox)->dropped_before, 0);
  inbox.put(kImage, bytes, /*may_wait=*/false);
  EXPECT_EQ(take(inbox)->dropped_before, 0);
  EXPECT_EQ(take(inbox)->dropped_before, 3);
  EXPECT_EQ(inbox.counts().frames, 6);
}

}  // namespace
}  // namespace eifmap
