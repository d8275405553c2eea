#include "sequence/decisions_file.h"

#include <gtest/gtest.h>

#include <limits>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

const std::vector<Decision> kDecisions{
    {0, kMost, -1, 0, kLeast}, {100, -5, 7, kAdoptedAtOnce, kMost}, {kMost, 0, kMost, 12, -1}};

std::string lines(const std::vector<Decision>& decisions, std::int64_t epoch = 0) {
  std::string text;
  for (const Decision& decision : decisions) text += line_of(decision, epoch) + "\n";
  return text;
}

TEST(DecisionsFile, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  for (const std::int64_t epoch : {0, 42}) {
    const DecisionsFile read = read_decisions(folder.write("d.jsonl", lines(kDecisions, epoch)));
    EXPECT_EQ(read.problem, "");
    EXPECT_EQ(read.decisions, kDecisions);
  }
}

TEST(DecisionsFile, ALineIsJsonThatSaysItsRun) {
  EXPECT_EQ(line_of({5, 6, 7, 8, 9}),
            R"({"utime":5,"publisher":6,"seq":7,"adopted_job":8,"state_digest":9})");
  EXPECT_EQ(
      line_of({5, 6, 7, 8, 9}, 10),
      R"({"utime":5,"publisher":6,"seq":7,"adopted_job":8,"state_digest":9,"server_epoch":10})");
}

TEST(DecisionsFile, NamesTheMeasurements) {
  const TemporaryFolder folder;
  const Decision decision{5, 6, 7, 8, 9, {{kLeast, 0}, {11, kMost}}};
  EXPECT_NE(line_of(decision).find(R"("measurements":[[-9223372036854775808,0],[11,)"),
            std::string::npos);
  const DecisionsFile read = read_decisions(folder.write("d.jsonl", line_of(decision)));
  EXPECT_EQ(read.problem, "");
  EXPECT_EQ(read.decisions.at(0), decision);
}

TEST(DecisionsFile, SaysWhereTheMapWasGivenUp) {
  const TemporaryFolder folder;
  Decision decision{5, 6, 7, 8, 9};
  EXPECT_EQ(line_of(decision).find("after_reset"), std::string::npos);
  decision.after_reset = true;
  const DecisionsFile read = read_decisions(folder.write("d.jsonl", line_of(decision)));
  EXPECT_EQ(read.problem, "");
  EXPECT_EQ(read.decisions.at(0), decision);
  const std::string bad =
      R"({"utime":5,"publisher":6,"seq":7,"adopted_job":8,"state_digest":9,"after_reset":1})";
  EXPECT_NE(read_decisions(folder.write("d.jsonl", bad)).problem, "");
}

TEST(DecisionsFile, LineEndsOfOthersAndEmptyLinesAreNoMatter) {
  const TemporaryFolder folder;
  const std::string text = line_of(kDecisions[0]) + "\r\n\n" + line_of(kDecisions[1]);
  const DecisionsFile read = read_decisions(folder.write("d.jsonl", text));
  EXPECT_EQ(read.problem, "");
  EXPECT_EQ(read.decisions.size(), 2u);
}

// The second line is `bad`.
std::string problem_of(const TemporaryFolder& folder, const std::string& bad) {
  const DecisionsFile read =
      read_decisions(folder.write("d.jsonl", line_of(kDecisions[1]) + "\n" + bad + "\n"));
  EXPECT_TRUE(read.problem.empty() || read.decisions.empty());
  return read.problem;
}

TEST(DecisionsFile, BadLinesAreNamed) {
  const TemporaryFolder folder;
  const std::string good = line_of(kDecisions[2]);
  EXPECT_EQ(problem_of(folder, good), "");
  const auto with = [&good](const std::string& from, const std::string& to) {
    std::string line = good;
    return line.replace(line.find(from), from.size(), to);
  };
  for (const std::string& bad :
       {std::string("{"), std::string("[]"), std::string("7"), std::string("no json"),
        good.substr(0, good.size() - 4), good + good, with("\"seq\"", "\"sec\""),
        with("\"adopted_job\":12", "\"adopted_job\":\"12\""),
        with("\"adopted_job\":12", "\"adopted_job\":1.5"),
        with("\"adopted_job\":12", "\"adopted_job\":true"),
        with("\"adopted_job\":12", "\"adopted_job\":12,\"server_epoch\":null"),
        with("\"state_digest\":-1", "\"state_digest\":1e300"),
        with("\"state_digest\"", "\"measurements\":7,\"state_digest\""),
        with("\"state_digest\"", "\"measurements\":[7],\"state_digest\""),
        with("\"state_digest\"", "\"measurements\":[[7]],\"state_digest\""),
        with("\"state_digest\"", "\"measurements\":[[7,1.5]],\"state_digest\"")}) {
    const std::string problem = problem_of(folder, bad);
    EXPECT_NE(problem.find("d.jsonl line 2: is no decision"), std::string::npos) << bad << problem;
  }
}

TEST(DecisionsFile, IsOfOneRun) {
  const TemporaryFolder folder;
  for (const std::int64_t time : {100, 99, -1}) {
    const std::string problem = problem_of(folder, line_of({time, 0, 0, 0, 0}));
    EXPECT_NE(problem.find("d.jsonl line 2: its utime is not after"), std::string::npos) << problem;
  }
  const std::string problem = problem_of(folder, line_of(kDecisions[2], 43));
  EXPECT_NE(problem.find("d.jsonl line 2: another run of the server"), std::string::npos)
      << problem;
}

TEST(DecisionsFile, NoneIsAProblem) {
  const TemporaryFolder folder;
  EXPECT_NE(read_decisions(folder.path() / "none.jsonl").problem.find("none.jsonl: cannot be read"),
            std::string::npos);
  EXPECT_NE(read_decisions(folder.write("d.jsonl", "\n")).problem.find("d.jsonl: has no decisions"),
            std::string::npos);
}

}  // namespace
}  // namespace eifmap
