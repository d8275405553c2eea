#include "client/view/page_queue.h"

#include <gtest/gtest.h>

namespace eifmap {
namespace {

SharedMessage message(const std::string& bytes, bool binary = false) {
  return std::make_shared<PageMessage>(PageMessage{bytes, binary});
}

// What is popped until the queue is empty, one after the other.
std::string all_of(PageQueue& queue) {
  std::string text;
  while (!queue.empty()) text += queue.pop([] { return message("snapshot "); })->bytes;
  return text;
}

TEST(PageQueue, BeginsWithASnapshotAndGoesOnWithIncrements) {
  PageQueue queue(100);
  EXPECT_FALSE(queue.empty());
  queue.push(message("before "));
  EXPECT_EQ(all_of(queue), "snapshot ") << "the snapshot has what was before it";
  queue.push(message("a "));
  queue.push(message("b "));
  EXPECT_EQ(queue.waiting_bytes(), 4u);
  EXPECT_EQ(all_of(queue), "a b ");
  EXPECT_EQ(queue.waiting_bytes(), 0u);
  EXPECT_EQ(queue.pop([] { return message("snapshot "); }), nullptr);
}

TEST(PageQueue, OfASlowPageNothingPilesUp) {
  PageQueue queue(100);
  all_of(queue);
  for (int i = 0; i < 1000; ++i) {
    queue.push(message("0123456789"));
    ASSERT_LE(queue.waiting_bytes(), 100u);
  }
  EXPECT_EQ(all_of(queue), "snapshot ");
  queue.push(message("next"));
  EXPECT_EQ(all_of(queue), "next");
}

TEST(PageQueue, OnlyTheNewestPictureWaits) {
  PageQueue queue(100);
  for (int i = 0; i < 5; ++i) queue.push_picture(message("picture" + std::to_string(i), true));
  EXPECT_EQ(all_of(queue), "snapshot picture4");
}

}  // namespace
}  // namespace eifmap
