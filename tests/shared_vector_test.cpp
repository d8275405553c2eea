// Copies share pieces and go their own ways all the same.
#include "shared_vector.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <thread>

namespace eifmap {
namespace {

using Shared = SharedVector<std::string, 4>;

void expect_equal(const Shared& have, const std::vector<std::string>& want) {
  ASSERT_EQ(have.size(), want.size());
  EXPECT_TRUE(std::equal(have.begin(), have.end(), want.begin()));
  for (std::size_t i = 0; i < want.size(); ++i) EXPECT_EQ(have.at(i), want[i]);
}

// Whatever is done to some of several copies, each is what a std::vector of its own would be.
TEST(SharedVector, CopiesAreWhatVectorsAre) {
  constexpr int kCopies = 4;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    const auto draw = [&random](std::size_t below) { return random() % below; };
    std::vector<Shared> shared(kCopies);
    std::vector<std::vector<std::string>> plain(kCopies);
    for (int step = 0; step < 400; ++step) {
      const std::size_t a = draw(kCopies), b = draw(kCopies);
      const std::string text = std::to_string(step);
      switch (draw(plain[a].empty() ? 2 : 10)) {
        case 0:
        case 1:
          shared[a].push_back(text), plain[a].push_back(text);
          break;
        case 2:
          shared[a] = shared[b], plain[a] = plain[b];
          break;
        case 3: {
          const auto some = [&](const std::string& s) { return s.back() == text.back(); };
          EXPECT_EQ(shared[a].erase_if(some), std::erase_if(plain[a], some));
          break;
        }
        case 4: {
          if (a == b) break;
          shared[a] = std::move(shared[b]), plain[a] = plain[b];
          shared[b] = Shared(), plain[b].clear();
          break;
        }
        case 5:
        case 6: {  // old ones, so that whole pieces become so
          const std::size_t at = draw(plain[a].size() / 2 + 1);
          shared[a].reset(at), plain[a][at].clear();
          break;
        }
        default: {
          const std::size_t at = draw(plain[a].size());
          shared[a].write(at) += text, plain[a][at] += text;
        }
      }
      for (int c = 0; c < kCopies; ++c) ASSERT_NO_FATAL_FAILURE(expect_equal(shared[c], plain[c]));
    }
  }
}

TEST(SharedVector, CopiesOnlyThePiecesThatAreWrittenTo) {
  Shared one;
  for (int i = 0; i < 40; ++i) one.push_back("x");
  EXPECT_EQ(one.num_shared_pieces(), 0u);
  Shared other = one;
  EXPECT_EQ(one.num_shared_pieces(), 10u);
  EXPECT_EQ(other.num_shared_pieces(), 10u);
  other.write(5) = "y", other.write(6) = "z";
  EXPECT_EQ(other.num_shared_pieces(), 9u);
  EXPECT_EQ(&one[8], &other[8]);
  EXPECT_NE(&one[4], &other[4]);
  one.write(5) = "w";
  EXPECT_EQ(one[5], "w");
  EXPECT_EQ(other[5], "y");
}

// What ever was in it and is no more costs a pointer for each piece.
TEST(SharedVector, HoldsNoPieceOfWhichAllWasReset) {
  Shared one;
  for (int i = 0; i < 40; ++i) one.push_back("x");
  const Shared before = one;
  for (std::size_t i = 0; i < 38; ++i)
    if (i != 9) one.reset(i);
  EXPECT_EQ(one.num_pieces_held(), 2u);
  EXPECT_EQ(before.num_pieces_held(), 10u);
  EXPECT_EQ(before[0], "x");
  EXPECT_EQ(one[0], "");
  EXPECT_EQ(one[9], "x");
  one.write(1) = "y";
  EXPECT_EQ(one.num_pieces_held(), 3u);
  const std::vector<std::string> first = {"", "y", "", ""};
  EXPECT_TRUE(std::equal(first.begin(), first.end(), one.begin()));
  EXPECT_EQ(one[4], "");
  one.reset(1);
  EXPECT_EQ(one.num_pieces_held(), 2u);
}

TEST(SharedVector, RefusesWhatIsBeyondItsEnd) {
  Shared none;
  EXPECT_THROW(none.at(0), std::out_of_range);
}

// For the thread sanitizer: one thread reads and copies the map while another writes to its copy,
// and who lets go first is left to chance.
TEST(SharedVector, CopiesAreSafeInTwoThreads) {
  for (int round = 0; round < 20; ++round) {
    Shared read;
    for (int i = 0; i < 200; ++i) read.push_back(std::to_string(i));
    Shared written = read;
    std::size_t length = 0;
    std::thread writer([&written] {
      for (std::size_t i = 0; i < written.size(); ++i) written.write(i) += "!";
    });
    {
      const Shared copy = read;
      for (const std::string& text : copy) length += text.size();
      read = Shared();
    }
    writer.join();
    EXPECT_EQ(length, 490u);
    EXPECT_EQ(written[123], "123!");
  }
}

}  // namespace
}  // namespace eifmap
