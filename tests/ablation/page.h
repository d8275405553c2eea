// The results as a page of Markdown tables, and as JSON lines.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "ablation/runs.h"

namespace eifmap::test {

struct RecordingResult {
  std::string name;
  int images = 0;
  bool truth_is_exact = false;
  Outcomes outcomes;  // by row, by seed
};

struct Results {
  std::vector<Row> rows;
  int seeds = 0;
  std::vector<RecordingResult> recordings;
  std::vector<std::string> skipped;  // recordings that are not there
};

// What was run, how to run it again, and a table for each group of rows.
std::string tables_text(const Results& results);

// `page` with the part between its two markers replaced; all else, which is written by hand, stays.
// "" gets a new page. Throws std::runtime_error on a page without the markers.
std::string page_with_tables(const std::string& page, const std::string& tables);

// An object a line for each row and seed.
std::string json_lines(std::span<const Row> rows, const RecordingResult& result);

}  // namespace eifmap::test
