#include "server/part_collector.h"

#include <gtest/gtest.h>

#include "messages/samples.h"

namespace eifmap {
namespace {

using Clock = PartCollector::Clock;

std::vector<std::vector<std::uint8_t>> parts_of(std::int64_t seq, int features,
                                                const std::string& camera = "cam0") {
  FeatureFrame frame = samples::features(features);
  frame.camera = camera;
  frame.seq = seq;
  frame.time_us += seq;
  std::vector<std::vector<std::uint8_t>> messages;
  for (const feature_frame_t& part : split_features(frame, 1400)) messages.push_back(encode(part));
  return messages;
}

class PartCollectorTest : public testing::Test {
 protected:
  void take(const std::vector<std::uint8_t>& message, const std::string& camera = "cam0") {
    collector_.take(camera, message, now_);
  }
  std::vector<std::int64_t> seqs() const {
    std::vector<std::int64_t> seqs;
    for (const auto& [camera, bytes] : delivered_) seqs.push_back(decode_features(bytes).value.seq);
    return seqs;
  }

  Clock::time_point now_ = Clock::now();
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> delivered_;
  bool may_wait_ = true;
  PartCollector collector_{[this](const std::string& camera, Bytes bytes, bool may_wait) {
    may_wait_ = may_wait;
    collector_.counts();  // as the mapping thread asks, also while a delivery waits for it
    collector_.give_up_silent(now_ + std::chrono::hours(1));
    delivered_.emplace_back(camera, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
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
  EXPECT_EQ(delivered_[1].second, whole[0]);
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
  EXPECT_EQ(delivered_[0].second, garbage);
  EXPECT_EQ(delivered_[1].second, part);
}

TEST_F(PartCollectorTest, ManyNamesDoNotKeepARealCameraOut) {
  for (int i = 0; i < 1000; ++i) {
    const std::string name = "made_up_" + std::to_string(i);
    now_ += std::chrono::milliseconds(1);
    take(parts_of(1, 100, name)[0], name);
  }
  EXPECT_EQ(delivered_.size(), 1000 - PartCollector::kMaxCameras);
  delivered_.clear();
  for (const auto& part : parts_of(10, 100)) take(part);
  EXPECT_EQ(delivered_.back().first, "cam0");
  EXPECT_EQ(seqs().back(), 10);
}

TEST_F(PartCollectorTest, OfOthersThanTheSelectedNothingIsPutTogether) {
  collector_.select_camera("cam0");
  for (const auto& part : parts_of(1, 100, "other")) take(part, "other");
  EXPECT_EQ(delivered_.size(), 1u) << "one frame to count, not one a part";
  EXPECT_EQ(collector_.counts().whole, 0);
  for (const auto& part : parts_of(1, 100)) take(part);
  EXPECT_EQ(collector_.counts().whole, 1);
}

}  // namespace
}  // namespace eifmap
