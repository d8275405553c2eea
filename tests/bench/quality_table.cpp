// Prints the table of src/features/quality.md. Run: eifmap_quality_table
#include <cstdio>

#include "features/quality.h"

int main() {
  using namespace eifmap::testing;
  std::puts(
      "| second view | features of | in a view | found again | matches | right | location RMS, px "
      "|\n"
      "|---|---|---|---|---|---|---|");
  for (const Row& row : measure_quality(4))
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      const PairFigures& f = row.of[m];
      std::printf("| %s | %s | %d | %.0f %% | %d | %.1f %% | %.3f |\n",
                  m == 0 ? row.change.name.c_str() : "", name(kMethods[m]).c_str(), row.features[m],
                  100 * f.repeatability(), f.matches / 4, 100 * f.precision(), f.rms());
    }
}
