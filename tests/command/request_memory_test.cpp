#include "server/request_memory.h"

#include <gtest/gtest.h>

namespace eifmap {
namespace {

using Reply = std::vector<std::uint8_t>;

TEST(RequestMemory, TheSameRequestHasTheSameReply) {
  RequestMemory memory;
  EXPECT_EQ(memory.reply_to({1, 1, 10}), nullptr);
  EXPECT_EQ(memory.problem({1, 1, 10}), "");
  memory.keep({1, 1, 10}, {7});
  memory.keep({2, 1, 10}, {8});
  ASSERT_TRUE(memory.reply_to({1, 1, 10}));
  EXPECT_EQ(*memory.reply_to({1, 1, 10}), Reply{7});
  EXPECT_EQ(*memory.reply_to({2, 1, 10}), Reply{8});
  EXPECT_EQ(memory.reply_to({1, 2, 10}), nullptr);
}

TEST(RequestMemory, WhatCameAfterALaterOneIsOld) {
  RequestMemory memory;
  memory.keep({1, 5, 10}, {});
  EXPECT_NE(memory.problem({1, 4, 10}), "") << "delayed on the way, and given up by its sender";
  EXPECT_EQ(memory.problem({1, 6, 10}), "");
  EXPECT_EQ(memory.problem({2, 4, 10}), "") << "of somebody else";
}

TEST(RequestMemory, WhatIsForgottenIsOld) {
  RequestMemory memory;
  constexpr int kMost = static_cast<int>(RequestMemory::kMostRequests);
  for (int i = 1; i <= kMost + 3; ++i) memory.keep({i, 1, 100 + i}, {1});
  EXPECT_EQ(memory.size(), RequestMemory::kMostRequests);
  for (int i = 1; i <= kMost + 3; ++i) {
    const RequestMemory::Request again{i, 1, 100 + i};
    EXPECT_TRUE(memory.reply_to(again) || memory.problem(again) != "") << i << " is done twice";
  }
  EXPECT_EQ(memory.problem({-1, 1, 104}), "") << "its ticket is of after what was forgotten";
  EXPECT_NE(memory.problem({-1, 1, 103}), "") << "it may be one that was";
}

TEST(RequestMemory, IsBoundedInBytes) {
  RequestMemory memory;
  for (int i = 1; i <= 100; ++i) memory.keep({i, 1, i}, Reply(100'000));
  EXPECT_LE(memory.size(), RequestMemory::kMostBytes / 100'000);
  memory.keep({101, 1, 101}, Reply(10 * RequestMemory::kMostBytes));
  EXPECT_TRUE(memory.reply_to({101, 1, 101})) << "the last one always";
  EXPECT_NE(memory.problem({100, 1, 100}), "");
}

}  // namespace
}  // namespace eifmap
