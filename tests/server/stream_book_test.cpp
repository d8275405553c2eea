#include "server/stream_book.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "wire/limits.h"

namespace eifmap {
namespace {

void take(StreamBook& book, std::initializer_list<std::int64_t> seqs, std::int64_t publisher = 7) {
  for (const std::int64_t seq : seqs) book.note({.publisher = publisher, .seq = seq}, 0);
}

TEST(StreamBook, WhatFollowsIsNeitherMissingNorLate) {
  StreamBook book;
  take(book, {500, 501, 502});
  ASSERT_EQ(book.streams().size(), 1u);
  const StreamCounts& counts = book.streams().front();
  EXPECT_EQ(counts.frames, 3);
  EXPECT_EQ(counts.missing + counts.reordered + counts.duplicates, 0);
}

TEST(StreamBook, ALateFrameIsNoLongerMissing) {
  StreamBook book;
  take(book, {0, 1, 4});
  EXPECT_EQ(book.missing(), 2);
  take(book, {3});
  EXPECT_EQ(book.missing(), 1);
  EXPECT_EQ(book.streams().front().reordered, 1);
  take(book, {3, 4});
  EXPECT_EQ(book.streams().front().duplicates, 2);
  EXPECT_EQ(book.missing(), 1);
}

TEST(StreamBook, WhatTheServerDroppedIsNotMissing) {
  StreamBook book;
  take(book, {0});
  book.note({.publisher = 7, .seq = 5}, 3);
  EXPECT_EQ(book.missing(), 1);
}

TEST(StreamBook, EachPublisherCountsByItself) {
  StreamBook book;
  take(book, {0, 2}, 7);
  take(book, {1000, 1001}, 8);
  EXPECT_EQ(book.restarts(), 1);
  EXPECT_EQ(book.missing(), 1);
  EXPECT_EQ(book.streams().front().publisher, 8);
  for (std::int64_t publisher = 20; publisher < 60; ++publisher) take(book, {0, 2}, publisher);
  EXPECT_LE(book.streams().size(), 8u) << "who starts for ever must not fill the memory";
  EXPECT_EQ(book.missing(), 41);
}

TEST(StreamBook, FramesWithoutNumbersAreCountedAlone) {
  StreamBook book;
  for (int i = 0; i < 3; ++i) book.note({}, 0);
  EXPECT_EQ(book.streams().front().frames, 3);
  EXPECT_EQ(book.missing(), 0);
}

TEST(StreamBook, TheClocksOffsetIsTheLeastDelay) {
  StreamBook book;
  for (const std::int64_t delay : {90, 40, 70})
    book.note({.publisher = 7, .time_us = 1000, .received_us = 1000 + delay}, 0);
  EXPECT_EQ(book.streams().front().clock_offset_us, 40);
}

TEST(StreamBook, ALeapOfTheNumbersIsTakenAtItsWord) {
  StreamBook book;
  take(book, {0, 1'000'000'000'000});
  EXPECT_EQ(book.missing(), 999'999'999'999);
  take(book, {5});
  EXPECT_EQ(book.streams().front().duplicates, 1);
}

TEST(StreamBook, AnOldNumberOfANewImageIsARestart) {
  StreamBook book;
  const auto arrive = [&book](std::int64_t seq, std::int64_t time_us) {
    book.note({.publisher = 7, .seq = seq, .time_us = time_us}, 0);
  };
  arrive(0, 100), arrive(1, 200), arrive(2, 300);
  arrive(0, 1000), arrive(2, 1200);
  EXPECT_EQ(book.restarts(), 1);
  EXPECT_EQ(book.missing(), 1);
  EXPECT_EQ(book.streams().front().duplicates, 0);
  arrive(1, 1100);
  EXPECT_EQ(book.restarts(), 1) << "that one was late";
  EXPECT_EQ(book.missing(), 0);
}

TEST(StreamBook, WhatCameBeforeTheFirstWasNotMissing) {
  StreamBook book;
  take(book, {2, 3, 5, 1});
  EXPECT_EQ(book.missing(), 1) << "4 is lost";
}

TEST(StreamBook, WildNumbersDoNotOverflow) {
  StreamBook book;
  for (int i = 0; i < 5000; ++i) {
    const std::int64_t time_us = 2 * i;
    book.note({.publisher = i % 3, .seq = 0, .time_us = time_us}, 0);
    book.note({.publisher = i % 3, .seq = kMaxSeq, .time_us = time_us + 1}, 0);
    ASSERT_GE(book.missing(), 0);
  }
}

// Any loss, reordering within the window and duplication: the book has the truth.
TEST(StreamBook, AgreesWithWhatALinkDid) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const auto chance = [&random](unsigned percent) { return random() % 100 < percent; };
    std::vector<std::int64_t> arrived;
    std::int64_t lost = 0, sent_twice = 0;
    constexpr std::int64_t kSent = 400;
    for (std::int64_t seq = 0; seq < kSent; ++seq) {
      // The last and the first arrive: of what is lost at the ends nobody can know.
      if (seq > 0 && seq + 1 < kSent && chance(5)) {
        ++lost;
        continue;
      }
      arrived.push_back(seq);
      if (!chance(3)) continue;
      arrived.push_back(seq);
      ++sent_twice;
    }
    for (std::size_t i = 1; i + 3 < arrived.size(); i += 3)
      if (chance(20)) std::swap(arrived[i], arrived[i + 1]);
    std::int64_t late = 0, newest = -1;
    std::set<std::int64_t> came;
    for (const std::int64_t seq : arrived) {
      late += came.insert(seq).second && seq < newest ? 1 : 0;
      newest = std::max(newest, seq);
    }
    StreamBook book;
    for (const std::int64_t seq : arrived) take(book, {seq});
    const StreamCounts& counts = book.streams().front();
    EXPECT_EQ(counts.frames, static_cast<std::int64_t>(arrived.size()));
    EXPECT_EQ(counts.missing, lost);
    EXPECT_EQ(counts.duplicates, sent_twice);
    EXPECT_EQ(counts.reordered, late) << "seed " << seed;
  }
}

}  // namespace
}  // namespace eifmap
