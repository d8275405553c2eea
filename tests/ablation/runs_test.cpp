#include "ablation/runs.h"

#include <gtest/gtest.h>

#include <atomic>

#include "ablation/workers.h"

namespace eifmap::test {
namespace {

TEST(Workers, DoAllOnce) {
  std::vector<std::atomic<int>> done(1000);
  in_workers(3, done.size(), [&](size_t i) { ++done[i]; });
  for (const auto& times : done) EXPECT_EQ(times, 1);
}

TEST(Workers, PassAnExceptionOn) {
  const auto fail = [](size_t i) {
    if (i == 5) throw std::runtime_error("five");
  };
  EXPECT_THROW(in_workers(2, 100, fail), std::runtime_error);
}

// Everything but the times.
std::vector<double> figures(const Outcomes& outcomes) {
  std::vector<double> all;
  for (const auto& seeds : outcomes)
    for (const Outcome& o : seeds)
      for (const double x :
           {o.ate_m.value_or(-1), o.coverage, o.nees.value_or(-1), static_cast<double>(o.frames),
            static_cast<double>(o.statistics.observations)})
        all.push_back(x);
  return all;
}

TEST(Runs, DoNotDependOnTheNumberOfThreads) {
  const auto recording = open_recording("courtyard", "", 30);
  ASSERT_TRUE(recording);
  const std::vector<Row> rows{
      {.group = "A", .name = "defaults"},
      {.group = "A", .name = "rate", .every = 2},
      {.group = "A", .name = "edges off", .patch = R"({"mapper": {"edge": {"enabled": false}}})"},
      {.group = "B",
       .name = "defaults again",
       .patch = R"({"mapper": {"edge": {"enabled": true}}})"}};
  std::string last;
  const Say say = [&](const std::string& done) { last = done; };
  const Outcomes alone = run_rows(*recording, rows, {.seeds = 2, .workers = 1}, say);
  EXPECT_EQ(last, "6 of 6 runs");  // of 8: the defaults are run once
  EXPECT_EQ(figures(alone), figures(run_rows(*recording, rows, {.seeds = 2, .workers = 3}, say)));

  const Outcome &first = alone[0][0], &second = alone[0][1];
  ASSERT_TRUE(first.ate_m && second.ate_m && first.nees);
  EXPECT_NE(*first.ate_m, *second.ate_m);  // the seeds are different
  EXPECT_LT(*first.ate_m, 0.05);           // m, of some 3 m walked
  EXPECT_EQ(first.frames, 30);
  EXPECT_EQ(alone[1][0].frames, 15);
  EXPECT_EQ(alone[2][0].statistics.edges, 0);
  EXPECT_EQ(alone[3][0].ate_m, first.ate_m);
  EXPECT_GT(first.extraction_ms, 0);
  EXPECT_GT(first.mapper_ms, 0);
}

TEST(Runs, SlowRowsHaveFewerSeeds) {
  const auto recording = open_recording("courtyard", "", 3);
  const std::vector<Row> rows{{.group = "A", .name = "paper", .paper = true},
                              {.group = "A", .name = "defaults"}};
  const Outcomes outcomes =
      run_rows(*recording, rows, {.seeds = 3, .slow_seeds = 2}, [](const std::string&) {});
  EXPECT_EQ(outcomes[0].size(), 2u);
  EXPECT_EQ(outcomes[1].size(), 3u);
  for (const auto& seeds : outcomes)
    for (const Outcome& outcome : seeds) EXPECT_EQ(outcome.frames, 3);
}

TEST(Runs, RecordingThatIsNotThereIsNone) {
  EXPECT_FALSE(open_recording("nowhere", "", 0));
}

}  // namespace
}  // namespace eifmap::test
