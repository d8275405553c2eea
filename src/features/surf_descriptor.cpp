#include "features/surf_descriptor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "features/cell_grid.h"
#include "features/descriptor_bytes.h"
#include "features/vector_clones.h"

namespace eifmap {
namespace {

constexpr int kSamples = 20;  // Haar responses per axis
constexpr int kRegions = 4;   // per axis
constexpr int kPadded = CellGrid::kPadded;

// weights[p][k]: what sample k gives to subregion p along one axis.
struct Weights {
  float of[kRegions][kSamples];
};

const Weights& sample_weights() {
  static const Weights weights = [] {
    Weights w{};
    for (int p = 0; p < kRegions; ++p)
      for (int k = 0; k < kSamples; ++k) {
        const double place = k - 0.5 * (kSamples - 1);
        const double distance = std::abs(place - 5.0 * (p - 0.5 * (kRegions - 1)));
        const double sharing = std::max(0.0, 1.0 - distance / 5.0);
        w.of[p][k] = static_cast<float>(sharing * std::exp(-0.5 * place * place / (3.3 * 3.3)));
      }
    return w;
  }();
  return weights;
}

// The four quantities summed down the columns of a subregion's row.
struct ColumnSums {
  alignas(32) float of[4][kRegions][kPadded] = {};
};

EIFMAP_VECTOR_CLONES
void sum_columns(const CellGrid& cells, const Weights& weights, ColumnSums& sums) {
  alignas(32) float dx[kPadded], dy[kPadded];
  for (int j = 0; j < kSamples; ++j) {
    const float* upper = cells.mean[j];
    const float* lower = cells.mean[j + 1];
    for (int i = 0; i < kPadded - 1; ++i) {
      const float a = upper[i], b = upper[i + 1], c = lower[i], d = lower[i + 1];
      dx[i] = (b + d) - (a + c);
      dy[i] = (c + d) - (a + b);
    }
    dx[kPadded - 1] = dy[kPadded - 1] = 0;
    for (int p = 0; p < kRegions; ++p) {
      const float w = weights.of[p][j];
      if (w == 0) continue;
      for (int i = 0; i < kPadded; ++i) {
        sums.of[0][p][i] += w * dx[i];
        sums.of[1][p][i] += w * std::fabs(dx[i]);
        sums.of[2][p][i] += w * dy[i];
        sums.of[3][p][i] += w * std::fabs(dy[i]);
      }
    }
  }
}

}  // namespace

void surf_descriptor(const IntegralImage& integral, float u, float v, float scale, float angle,
                     std::int8_t* descriptor) {
  CellGrid cells;
  if (angle == 0)
    cells.sample(integral, u, v, scale);
  else
    cells.sample_turned(integral, u, v, scale, angle);
  const Weights& weights = sample_weights();
  ColumnSums sums;
  sum_columns(cells, weights, sums);
  std::array<double, kDescriptorSize> values{};
  for (std::size_t p = 0; p < kRegions; ++p)
    for (std::size_t q = 0; q < kRegions; ++q)
      for (std::size_t m = 0; m < 4; ++m) {
        float sum = 0;
        for (std::size_t i = 0; i < kSamples; ++i) sum += weights.of[q][i] * sums.of[m][p][i];
        values[(kRegions * p + q) * 4 + m] = sum;
      }
  write_descriptor(values, descriptor);
}

}  // namespace eifmap
