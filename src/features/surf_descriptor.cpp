#include "features/surf_descriptor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "features/cell_grid.h"
#include "features/descriptor_bytes.h"
#include "vector_clones.h"

namespace eifmap {
namespace {

constexpr int kSamples = 20;  // Haar responses per axis
constexpr int kRegions = 4;   // per axis
constexpr int kPadded = CellGrid::kPadded;

// of[p][k]: what sample k gives to subregion p along one axis; 0 outside [begin[p], end[p]).
struct Weights {
  float of[kRegions][kSamples];
  int begin[kRegions], end[kRegions];
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
        if (sharing > 0) w.end[p] = k + 1;
        if (w.end[p] == 0) w.begin[p] = k + 1;
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

// The quantities of all subregions, summed along their rows, too. In vectors of the four quantities
// of the four rows of subregions.
EIFMAP_VECTOR_CLONES
void sum_rows(const ColumnSums& sums, const Weights& weights, double* __restrict values) {
  alignas(64) float column[kSamples][4 * kRegions];
  for (int i = 0; i < kSamples; ++i)
    for (int p = 0; p < kRegions; ++p)
      for (int m = 0; m < 4; ++m) column[i][4 * p + m] = sums.of[m][p][i];
  for (int q = 0; q < kRegions; ++q) {
    alignas(64) float total[4 * kRegions] = {};
    for (int i = weights.begin[q]; i < weights.end[q]; ++i) {
      const float w = weights.of[q][i];
      for (int k = 0; k < 4 * kRegions; ++k) total[k] += w * column[i][k];
    }
    for (int p = 0; p < kRegions; ++p)
      for (int m = 0; m < 4; ++m) values[4 * (kRegions * p + q) + m] = total[4 * p + m];
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
  sum_rows(sums, weights, values.data());
  write_descriptor(values, descriptor);
}

}  // namespace eifmap
