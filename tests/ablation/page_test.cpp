#include "ablation/page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

namespace eifmap::test {
namespace {

Outcome outcome(double ate_m, double coverage) {
  Outcome outcome;
  outcome.ate_m = ate_m;
  outcome.coverage = coverage;
  outcome.extraction_ms = 10;
  outcome.mapper_ms = 2.5;
  return outcome;
}

Results results_of(std::vector<Outcome> seeds) {
  Results results;
  results.rows = {{.group = "Group", .name = "row", .every = 5}};
  results.seeds = static_cast<int>(seeds.size());
  results.recordings = {{"place", 100, seeds.front().nees.has_value(), {seeds}}};
  return results;
}

std::string row_of(const Results& results) {
  const std::string page = tables_text(results);
  return page.substr(page.find("| row |"));
}

TEST(Page, HasMeanAndWorstErrorAndLeastCoverage) {
  EXPECT_EQ(row_of(results_of({outcome(0.1, 1), outcome(0.3, 0.9999)})),
            "| row | every 5th image | 0.200 / 0.300 | 0.999 | 12.5 |\n");
}

TEST(Page, ShowsLostRuns) {
  EXPECT_EQ(row_of(results_of({outcome(0.1, 1), outcome(0.001, 0.05)})),
            "| row | every 5th image | 0.100 / **lost** 1 of 2 | 0.050 | 12.5 |\n");
  Outcome nothing = outcome(0, 0.5);
  nothing.ate_m.reset();
  EXPECT_EQ(row_of(results_of({nothing, nothing})),
            "| row | every 5th image | **lost** | 0.500 | 12.5 |\n");
}

TEST(Page, HasNeesOfTheRunsThatWereNotLost) {
  Outcome good = outcome(0.1, 1), lost = outcome(0.1, 0);
  good.nees = 5.25;
  lost.nees = 1000;
  EXPECT_EQ(row_of(results_of({good, lost})),
            "| row | every 5th image | 0.100 / **lost** 1 of 2 | 0.000 | 5.2 | 12.5 |\n");
  good.nees = std::numeric_limits<double>::infinity();
  EXPECT_NE(row_of(results_of({good})).find("| no bound |"), std::string::npos);
}

TEST(Page, HasAsManyCellsInEachLineOfATable) {
  Outcome judged = outcome(0.1, 1);
  judged.nees = 6;
  Results results = results_of({judged});
  results.recordings.push_back({"elsewhere", 7, false, {{outcome(1, 1)}}});
  std::istringstream page(tables_text(results));
  int lines = 0;
  for (std::string line; std::getline(page, line);) {
    if (line.empty() || line[0] != '|') continue;
    ++lines;
    EXPECT_EQ(std::count(line.begin(), line.end(), '|'), 1 + 2 + 4 + 3) << line;
  }
  EXPECT_EQ(lines, 3);
}

TEST(Page, SaysWhichRowsHaveFewerSeeds) {
  Results results = results_of({outcome(0.1, 1)});
  EXPECT_EQ(tables_text(results).find("| row (1 seed) |"), std::string::npos);
  results.seeds = 5;
  EXPECT_NE(tables_text(results).find("| row (1 seed) |"), std::string::npos);
}

TEST(Page, SaysWhatWasSkipped) {
  Results results = results_of({outcome(0.1, 1)});
  EXPECT_EQ(tables_text(results).find("skipped"), std::string::npos);
  results.skipped = {"nowhere"};
  EXPECT_NE(tables_text(results).find("nowhere: skipped"), std::string::npos);
}

TEST(Page, KeepsWhatIsWrittenByHand) {
  std::string page = page_with_tables("", "old tables\n");
  page = "Before.\n" + page + "After.\n";
  const std::string again = page_with_tables(page, "new tables\n");
  std::string expected = page;
  expected.replace(expected.find("old"), 3, "new");
  EXPECT_EQ(again, expected);
  EXPECT_THROW(page_with_tables("by hand alone", "tables"), std::runtime_error);
}

TEST(Page, HasAJsonLineForEachRun) {
  Outcome lost = outcome(0.1, 0.01);
  lost.ate_m.reset();
  const Results results = results_of({outcome(0.1, 1), lost});
  std::istringstream lines(json_lines(results.rows, results.recordings[0]));
  std::vector<nlohmann::json> runs;
  for (std::string line; std::getline(lines, line);) runs.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0]["ate_m"], 0.1);
  EXPECT_EQ(runs[0]["every"], 5);
  EXPECT_EQ(runs[1]["seed"], 2);
  EXPECT_TRUE(runs[1]["ate_m"].is_null());
  EXPECT_TRUE(runs[1]["lost"]);
}

}  // namespace
}  // namespace eifmap::test
