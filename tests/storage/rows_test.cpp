// The rows of a map's records.
#include "storage/rows.h"

#include <gtest/gtest.h>
#include <malloc.h>

namespace eifmap::test {
namespace {

// Bytes that the process has from the allocator.
std::size_t in_use() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(RowBook, HoldsNothingOfAWholeMapsRecord) {
  constexpr std::size_t kSize = 8u << 20, kLittle = 1u << 20;
  const std::vector<std::uint8_t> row(kSize, 1);
  const std::size_t before = in_use();
  RowBook book;
  book.put({Table::kFrame, 0}, row);
  EXPECT_GE(in_use(), before + kSize);
  EXPECT_GE(book.record().size(), kSize);
  book.keep();
  EXPECT_LT(in_use(), before + kLittle) << "written";
  book.put({Table::kFrame, 1}, row);
  book.drop();
  EXPECT_LT(in_use(), before + kLittle) << "not written";
  EXPECT_EQ(book.size(), 1u);
}

}  // namespace
}  // namespace eifmap::test
