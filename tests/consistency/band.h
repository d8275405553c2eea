// A statistic over many runs next to where it should be.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace eifmap::test {

// Where the mean of `runs` normalized errors squared of `degrees` degrees of freedom lies in 95 %
// of all cases: chi-square of runs * degrees, over runs (E. B. Wilson, M. M. Hilferty, PNAS 1931).
std::array<double, 2> band_95(int runs, int degrees);

// Normalized errors squared, one number a run: a single one, or the mean of several. Those of one
// run are correlated, at most completely, so that the mean over runs is within band_95() at least
// as often as it says. Where they are not, their mean's own spread says more: see deviation().
struct RunStatistic {
  std::string name;
  int degrees = 6;
  std::vector<double> of_runs;

  double mean() const;
  // How far the mean is from `degrees`, in standard deviations of a mean that varies from run to
  // run as these do.
  double deviation() const;
  std::array<double, 2> band() const { return band_95(static_cast<int>(of_runs.size()), degrees); }
  bool in_band() const;
};

}  // namespace eifmap::test
