// Robust statistics shared by the fits: bisquare weights (A. Beaton, J. Tukey, Technometrics 1974)
// and spreads from medians.
#pragma once

#include <algorithm>
#include <vector>

namespace eifmap {

// A whitened residual's standard deviation from the median of its magnitudes: of one normal
// variable, and of the norm of two.
inline constexpr double kSpreadFromMedian1d = 1.4826;
inline constexpr double kSpreadFromMedian2d = 0.8493;

// Tuning constant of the bisquare: 95 % efficient on normal residuals.
inline constexpr double kBisquare = 4.685;

// 1 at residual 0, falling to 0 at +-limit and staying there.
inline double bisquare_weight(double residual, double limit) {
  const double u = residual / limit;
  const double v = 1 - u * u;
  return v > 0 ? v * v : 0;
}

// The cost that the weight belongs to: residual^2 / 2 near 0, limit^2 / 6 from the limit on.
inline double bisquare_cost(double residual, double limit) {
  const double u = residual / limit;
  const double v = std::max(0.0, 1 - u * u);
  return limit * limit / 6 * (1 - v * v * v);
}

// The second derivative of that cost; negative from limit / sqrt(5) on.
inline double bisquare_curvature(double residual, double limit) {
  const double u = residual / limit;
  const double v = 1 - u * u;
  return v > 0 ? v * (1 - 5 * u * u) : 0;
}

// The upper median; 0 of nothing. Reorders `values`.
inline double take_median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace eifmap
