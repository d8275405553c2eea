#include "server/part_collector.h"

#include <gtest/gtest.h>

#include "messages/samples.h"

namespace eifmap {
namespace {

using Clock = PartCollector::Clock;

std::vector<std::vector<std::uint8_t>> parts_of(std::int64_t seq, int features) {
  FeatureFrame frame = samples::features(features);
  frame.seq = seq;
  frame.time_us += seq;
  std::vector<std::vector<std::uint8_t>> messages;
  for (const feature_frame_t& part : split_features(frame, 1400)) messages.push_back(encode(part));
  return messages;
}

class PartCollectorTest : public testing::Test {
 protected:
  void take(const std::vector<std::uint8_t>& message) { collector_.take(message, now_); }
  std::vector<std::int64_t> seqs() const {
    std::vector<std::int64_t> seqs;
    for (const auto& bytes : delivered_) seqs.push_back(decode_features(bytes).value.seq);
    return seqs;
  }

  Clock::time_point now_ = Clock::now();
  std::vector<std::vector<std::uint8_t>> delivered_;
  bool may_wait_ = true;
  PartCollector collector_{[this](Bytes bytes, bool may_wait) {
    may_wait_ = may_wait;
    collector_.counts();  // as the mapping thread asks, also while a delivery waits for it
    collector_.give_up_silent(now_ + std::chrono::hours(1));
    delivered_.emplace_back(bytes.begin(), bytes.end());
  }};
};

TEST_F(PartCollectorTest, AWholeFrameDoesNotOvertakeAnIncompleteOne) {
  const auto first = parts_of(10, 100);
  ASSERT_GT(first.size(), 2u);
  for (std::size_t p = 1; p < first.size(); ++p) take(first[p]);
  EXPECT_TRUE(delivered_.empty());
  const auto whole = parts_of(11, 5);
  ASSERT_EQ(whole.size(), 1u);
  take(whole[0]);
  EXPECT_EQ(seqs(), (std::vector<std::int64_t>{10, 11}));
  EXPECT_EQ(delivered_[1], whole[0]);
  EXPECT_EQ(collector_.counts().incomplete, 1);
  EXPECT_EQ(collector_.counts().missing_parts, 1);
  EXPECT_EQ(collector_.counts().whole, 0) << "of those in parts alone";
}

TEST_F(PartCollectorTest, TheLastFrameIsNotKeptForEver) {
  const auto last = parts_of(10, 100);
  for (std::size_t p = 1; p < last.size(); ++p) take(last[p]);
  collector_.give_up_silent(now_ + PartCollector::kSilence / 2);
  EXPECT_TRUE(delivered_.empty());
  collector_.give_up_silent(now_ + PartCollector::kSilence);
  EXPECT_EQ(seqs(), std::vector<std::int64_t>{10});
  EXPECT_FALSE(may_wait_) << "who gives up is who makes room";
  take(last[0]);
  EXPECT_EQ(collector_.counts().late_parts, 1);
}

TEST_F(PartCollectorTest, WhatIsNoGoodPartIsDeliveredAsItCame) {
  const std::vector<std::uint8_t> garbage(300, 0xee);
  take(garbage);
  auto part = parts_of(1, 100)[0];
  part.resize(part.size() - 1);
  take(part);
  ASSERT_EQ(delivered_.size(), 2u);
  EXPECT_EQ(delivered_[0], garbage);
  EXPECT_EQ(delivered_[1], part);
}

TEST_F(PartCollectorTest, WhoMayNotWaitDoesNotWait) {
  for (const auto& part : parts_of(10, 100)) collector_.take(part, now_, /*may_wait=*/false);
  EXPECT_EQ(seqs(), std::vector<std::int64_t>{10});
  EXPECT_FALSE(may_wait_);
}

}  // namespace
}  // namespace eifmap
