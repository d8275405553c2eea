#include "consistency/band.h"

#include <cmath>
#include <numeric>

namespace eifmap::test {

std::array<double, 2> band_95(int runs, int degrees) {
  const double n = static_cast<double>(runs) * degrees;
  const auto quantile = [n](double normal) {
    return n * std::pow(1 - 2 / (9 * n) + normal * std::sqrt(2 / (9 * n)), 3);
  };
  return {quantile(-1.96) / runs, quantile(1.96) / runs};
}

double RunStatistic::mean() const {
  return std::accumulate(of_runs.begin(), of_runs.end(), 0.0) / static_cast<double>(of_runs.size());
}

double RunStatistic::deviation() const {
  const auto n = static_cast<double>(of_runs.size());
  const double middle = mean();
  double squared = 0;
  for (const double value : of_runs) squared += (value - middle) * (value - middle);
  return (middle - degrees) / std::sqrt(squared / (n * (n - 1)));
}

bool RunStatistic::in_band() const {
  return mean() >= band()[0] && mean() <= band()[1];
}

}  // namespace eifmap::test
