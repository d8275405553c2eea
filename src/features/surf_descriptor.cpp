#include "features/surf_descriptor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "features/vector_clones.h"

namespace eifmap {
namespace {

constexpr int kSamples = 20;          // Haar responses per axis
constexpr int kCells = kSamples + 1;  // boxes of side `scale` per axis; a response takes 2x2
constexpr int kCorners = kCells + 1;
constexpr int kRegions = 4;  // per axis
constexpr int kPadded = 24;  // samples per row, padded to whole vectors

// Where the grid's lines cut one axis of the image: between integral entries index and index + 1.
struct Cuts {
  std::array<int, kCorners> index;
  std::array<double, kCorners> fraction;  // outside [0, 1] beyond the image: the border goes on
};

Cuts cut_axis(float centre, float scale, int size) {
  Cuts cuts;
  for (int k = 0; k < kCorners; ++k) {
    // Pixel x covers [x, x + 1) of the integral image's axis: its centre is at x + 0.5.
    const double x = centre + 0.5 + (k - 0.5 * kCells) * scale;
    const int index = std::clamp(static_cast<int>(std::floor(x)), 0, size - 1);
    cuts.index[static_cast<std::size_t>(k)] = index;
    cuts.fraction[static_cast<std::size_t>(k)] = x - index;
  }
  return cuts;
}

struct Cells {
  alignas(32) float sums[kCells][kPadded] = {};
};

// Exact sums of the image in each cell, relative to a corner so that they stay small.
void sum_cells(const IntegralImage& integral, const Cuts& columns, const Cuts& rows, Cells& cells) {
  const std::uint32_t base = integral.at(columns.index[0], rows.index[0]);
  const auto value = [base](std::uint32_t sum) {
    return static_cast<double>(static_cast<std::int32_t>(sum - base));
  };
  std::array<double, kCorners> above{}, here{};
  for (std::size_t j = 0; j < kCorners; ++j) {
    const std::uint32_t* upper = integral.row(rows.index[j]);
    const std::uint32_t* lower = integral.row(rows.index[j] + 1);
    for (std::size_t i = 0; i < kCorners; ++i) {
      const int c = columns.index[i];
      const double f = columns.fraction[i];
      const double u0 = value(upper[c]), u1 = value(upper[c + 1]);
      const double l0 = value(lower[c]), l1 = value(lower[c + 1]);
      const double u = u0 + f * (u1 - u0), l = l0 + f * (l1 - l0);
      here[i] = u + rows.fraction[j] * (l - u);
    }
    if (j > 0)
      for (std::size_t i = 0; i < kCells; ++i)
        cells.sums[j - 1][i] =
            static_cast<float>((here[i + 1] - here[i]) - (above[i + 1] - above[i]));
    above = here;
  }
}

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
void sum_columns(const Cells& cells, const Weights& weights, ColumnSums& sums) {
  alignas(32) float dx[kPadded], dy[kPadded];
  for (int j = 0; j < kSamples; ++j) {
    const float* upper = cells.sums[j];
    const float* lower = cells.sums[j + 1];
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

// To unit length with no entry over 0.5, as far as both can be had.
void quantize(std::array<double, kDescriptorSize>& values, std::int8_t* descriptor) {
  constexpr double kLargest = 0.5;
  for (int round = 0; round < 3; ++round) {
    double squares = 0;
    for (const double x : values) squares += x * x;
    const double factor = squares > 0 ? 1 / std::sqrt(squares) : 0;
    for (double& x : values) x = std::clamp(x * factor, -kLargest, kLargest);
  }
  for (std::size_t i = 0; i < kDescriptorSize; ++i)
    descriptor[i] = static_cast<std::int8_t>(std::lround(254 * values[i]));
}

}  // namespace

void surf_descriptor(const IntegralImage& integral, float u, float v, float scale,
                     std::int8_t* descriptor) {
  Cells cells;
  sum_cells(integral, cut_axis(u, scale, integral.width()), cut_axis(v, scale, integral.height()),
            cells);
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
  quantize(values, descriptor);
}

}  // namespace eifmap
