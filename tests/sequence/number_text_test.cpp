#include "sequence/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

namespace eifmap {
namespace {

TEST(NumberText, SplitsAtBlanksAndCommasUpToAComment) {
  const std::vector<std::string> wanted{"1", "2.5", "x"};
  EXPECT_EQ(split_words(" 1,2.5\tx \r# 7 8"), wanted);
  EXPECT_TRUE(split_words("# only this").empty());
  EXPECT_TRUE(split_words("").empty());
}

TEST(NumberText, ParsesTheWholeWordOrNothing) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500);
  EXPECT_EQ(parse_number("+2"), 2);
  EXPECT_TRUE(std::isnan(parse_number("nan").value()));
  for (const char* bad : {"", "1.5x", "one", "0x10", "1,5", "--1"})
    EXPECT_FALSE(parse_number(bad)) << bad;
}

TEST(NumberText, ExactTextReadsBackAsTheSameBits) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double value, back;
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) continue;
    back = parse_number(exact_text(value)).value();
    EXPECT_EQ(std::memcmp(&value, &back, sizeof(value)), 0) << exact_text(value);
  }
}

}  // namespace
}  // namespace eifmap
