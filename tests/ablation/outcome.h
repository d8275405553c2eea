// One run of the mapper over features in memory, and how it went.
#pragma once

#include <cstdint>
#include <optional>

#include "ablation/features_of.h"
#include "consistency/frame_source.h"
#include "map_view.h"
#include "options.h"

namespace eifmap::test {

inline constexpr double kLostCoverage = 0.1;  // with less in its final map a run was lost

struct Outcome {
  int frames = 0;               // given
  std::optional<double> ate_m;  // RMSE of the final trajectory; none: nothing to align
  double coverage = 0;          // share of the given frames in the final trajectory
  std::optional<double> nees;   // mean of the keyframes', 6 is right; where the truth is exact
  double extraction_ms = 0, mapper_ms = 0;  // CPU, for a frame given, on average
  MapperStatistics statistics;

  bool lost() const { return !ate_m || coverage < kLostCoverage; }
};

// With kJitterPx of noise from `seed`, the same as the server's --jitter-px and --seed. The same
// input gives the same outcome, CPU times apart, in whichever thread.
Outcome run_once(const Recording& recording, const FeatureSet& features,
                 const MapperOptions& options, std::uint64_t seed);

}  // namespace eifmap::test
