// What fuzzing has found so far stays as it is: every seed and every file of the corpus, without a
// fuzzer.
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "fuzz/target.h"
#include "sequence/file_text.h"

namespace eifmap::fuzz {

void PrintTo(const Target& target, std::ostream* out) {
  *out << target.name;
}

namespace {

namespace fs = std::filesystem;

class FuzzTest : public testing::TestWithParam<Target> {};

TEST_P(FuzzTest, SeedsAndCorpusRunThrough) {
  const auto seeds = GetParam().seeds();
  EXPECT_FALSE(seeds.empty());
  for (std::size_t i = 0; i < seeds.size(); ++i)
    EXPECT_TRUE(GetParam().run(seeds[i])) << "seed " << i << " leads nowhere";
  GetParam().run({});
  const fs::path corpus = fs::path(EIFMAP_FUZZ_CORPUS) / GetParam().name;
  ASSERT_TRUE(fs::is_directory(corpus)) << "make it by tests/fuzz/run";
  int files = 0;
  for (const auto& entry : fs::directory_iterator(corpus)) {
    const auto text = file_text(entry.path());
    ASSERT_TRUE(text) << entry.path();
    SCOPED_TRACE(entry.path());
    GetParam().run(wire_of(*text));
    ++files;
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzTest, testing::ValuesIn(all_targets()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace eifmap::fuzz
