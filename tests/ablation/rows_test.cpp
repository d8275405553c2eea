#include "ablation/rows.h"

#include <gtest/gtest.h>

#include <set>

namespace eifmap::test {
namespace {

TEST(Rows, FitTheConfiguration) {
  for (const Row& row : all_rows()) EXPECT_NO_THROW(config_of(row)) << row.group << row.name;
}

TEST(Rows, AreDifferentWithinATable) {
  std::set<std::string> seen;
  for (const Row& row : all_rows()) {
    const std::string what = row.group + config_text(config_of(row)) + std::to_string(row.every);
    EXPECT_TRUE(seen.insert(what).second) << row.group << ": " << row.name;
  }
}

TEST(Rows, SayWhichPatchDoesNotFit) {
  const Row row{.group = "A", .name = "b", .patch = R"({"mapper": {"nothing": 1}})"};
  try {
    config_of(row);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()).rfind("A: b: mapper.nothing", 0), 0u) << error.what();
  }
}

TEST(Rows, OfThePaperStartFromItsPreset) {
  const Row row{.group = "A", .name = "b", .patch = "{}", .paper = true};
  EXPECT_EQ(config_of(row).mapper.filter.relinearize, Relinearize::kOnce);
}

TEST(Rows, AreChosenByGroupAndName) {
  EXPECT_EQ(rows_with("").size(), all_rows().size());
  EXPECT_TRUE(rows_with("no such row").empty());
  for (const Row& row : rows_with("Features: SURF")) EXPECT_EQ(row.group, "Features");
  EXPECT_EQ(rows_with("Features: SURF").size(), 2u);
}

}  // namespace
}  // namespace eifmap::test
