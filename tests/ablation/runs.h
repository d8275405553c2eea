// All runs of all rows over one recording, each distinct one once.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ablation/outcome.h"
#include "ablation/rows.h"

namespace eifmap::test {

// What a recording gave: by row, by seed; slow rows have fewer.
using Outcomes = std::vector<std::vector<Outcome>>;

struct RunOptions {
  int seeds = 5;       // 1, 2, ... of the jitter
  int slow_seeds = 5;  // at most, of rows with the Unscented covariance: they take 5 times as long
  int workers = 2;     // threads; each run is in one
};

// Told what has been done, "12 of 105 runs"; from one thread at a time.
using Say = std::function<void(const std::string&)>;

// Rows that come to the same configuration and frames share their runs.
Outcomes run_rows(const Recording& recording, std::span<const Row> rows, const RunOptions& options,
                  const Say& say);

// About how long run_rows will compute, in CPU seconds, from what runs took before.
double estimated_cpu_s(const Recording& recording, std::span<const Row> rows,
                       const RunOptions& options);

}  // namespace eifmap::test
