#include "features/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "features/vector_clones.h"

namespace eifmap {
namespace {

constexpr int kCells = CellGrid::kCells;
constexpr int kPadded = CellGrid::kPadded;

// Where the grid's lines cut one axis of the image: between integral entries index and index + 1.
struct Cuts {
  alignas(32) std::int32_t index[kPadded];
  alignas(32) float fraction[kPadded];  // outside [0, 1] beyond the image: the border goes on
};

Cuts cut_axis(float centre, float side, int size) {
  Cuts cuts;
  // Pixel x covers [x, x + 1) of the integral image's axis: its centre is at x + 0.5.
  const float first = centre + 0.5f - 0.5f * kCells * side;
  for (int k = 0; k < kPadded; ++k) {
    const float x = first + static_cast<float>(std::min(k, kCells)) * side;
    const float index = std::clamp(std::floor(x), 0.0f, static_cast<float>(size - 1));
    cuts.index[k] = static_cast<std::int32_t>(index);
    cuts.fraction[k] = x - index;
  }
  return cuts;
}

// Sums of a row of cells, from rows of the integral image: exact integers until the last step.
struct Line {
  alignas(32) std::uint32_t left[kPadded], right[kPadded];  // at index and index + 1, upper entry
  alignas(32) float left_pixels[kPadded], right_pixels[kPadded];  // what one row of pixels adds
};

EIFMAP_VECTOR_CLONES
void sample_cells(const IntegralImage& integral, const Cuts& columns, const Cuts& rows,
                  float normalizer, float (*mean)[kPadded]) {
  Line lines[2];
  alignas(32) float cut[kPadded];
  for (int j = 0; j <= kCells; ++j) {
    Line& line = lines[j % 2];
    const Line& above = lines[(j + 1) % 2];
    const std::uint32_t* upper = integral.row(rows.index[j]);
    const std::uint32_t* lower = integral.row(rows.index[j] + 1);
    // The pixels of this row left of the grid's first column.
    const std::uint32_t base = lower[columns.index[0]] - upper[columns.index[0]];
    for (int k = 0; k < kPadded; ++k) {
      const std::int32_t c = columns.index[k];
      line.left[k] = upper[c];
      line.right[k] = upper[c + 1];
      line.left_pixels[k] =
          static_cast<float>(static_cast<std::int32_t>(lower[c] - upper[c] - base));
      line.right_pixels[k] =
          static_cast<float>(static_cast<std::int32_t>(lower[c + 1] - upper[c + 1] - base));
    }
    if (j == 0) continue;
    const float top = rows.fraction[j - 1], bottom = rows.fraction[j];
    const std::uint32_t first = line.left[0] - above.left[0];
    for (int k = 0; k < kPadded; ++k) {
      const float left =
          static_cast<float>(static_cast<std::int32_t>(line.left[k] - above.left[k] - first)) +
          (bottom * line.left_pixels[k] - top * above.left_pixels[k]);
      const float right =
          static_cast<float>(static_cast<std::int32_t>(line.right[k] - above.right[k] - first)) +
          (bottom * line.right_pixels[k] - top * above.right_pixels[k]);
      cut[k] = left + columns.fraction[k] * (right - left);
    }
    for (int k = 0; k < kCells; ++k) mean[j - 1][k] = (cut[k + 1] - cut[k]) * normalizer;
  }
}

// One side of each cell of a row along one axis.
struct Sides {
  alignas(32) std::int32_t index[kPadded];
  alignas(32) float fraction[kPadded];

  void cut(float first, float step, int size) {
    const float last = static_cast<float>(size - 1);
    for (int k = 0; k < kPadded; ++k) {
      const float x = first + static_cast<float>(k) * step;
      index[k] = static_cast<std::int32_t>(std::min(std::max(x, 0.0f), last));
      fraction[k] = x - static_cast<float>(index[k]);
    }
  }
};

// What a row of cells reads of one row of the integral image: per cell, the entries at the columns
// that its left and its right side cut, two each. Neighbours are read at once: processors do not
// gather any faster than one by one.
struct Entries {
  alignas(32) std::uint32_t of[kPadded][4];
};

[[gnu::noinline]] void read_entries(const std::uint32_t* sums, const std::int32_t* offsets,
                                    const Sides& left, const Sides& right, Entries& entries) {
  for (int k = 0; k < kPadded; ++k) {
    const std::uint32_t* row = sums + offsets[k];
    std::memcpy(&entries.of[k][0], row + left.index[k], 2 * sizeof *row);
    std::memcpy(&entries.of[k][2], row + right.index[k], 2 * sizeof *row);
  }
}

// One row of a turned grid, from its first cell's top left corner on.
EIFMAP_VECTOR_CLONES
void average_row(const IntegralImage& integral, float x, float y, float along, float across,
                 float side, float* __restrict mean) {
  Sides left, right, top, bottom;
  left.cut(x, along, integral.width());
  right.cut(x + side, along, integral.width());
  top.cut(y, across, integral.height());
  bottom.cut(y + side, across, integral.height());
  const std::uint32_t* sums = integral.row(0);
  const std::int32_t stride = integral.width() + 1;
  alignas(32) std::int32_t above[kPadded], below[kPadded];
  for (int k = 0; k < kPadded; ++k) {
    above[k] = top.index[k] * stride;
    below[k] = bottom.index[k] * stride;
  }
  Entries upper, upper_next, lower, lower_next;
  read_entries(sums, above, left, right, upper);
  read_entries(sums + stride, above, left, right, upper_next);
  read_entries(sums, below, left, right, lower);
  read_entries(sums + stride, below, left, right, lower_next);
  const float normalizer = 1.0f / (side * side);
  for (int k = 0; k < kPadded; ++k) {
    // Sums of whole pixels from the first one that the cell cuts to entry c of the row: exact
    // integers.
    const auto until = [&, k](const Entries& row, int c) {
      return static_cast<float>(static_cast<std::int32_t>((row.of[k][c] - row.of[k][0]) -
                                                          (upper.of[k][c] - upper.of[k][0])));
    };
    // Of those rows, between the cell's left and right side.
    const auto strip = [&, k](const Entries& row) {
      const float whole = until(row, 2), next = until(row, 3);
      return whole + right.fraction[k] * (next - whole) - left.fraction[k] * until(row, 1);
    };
    const float whole = strip(lower), next = strip(lower_next);
    mean[k] = (whole + bottom.fraction[k] * (next - whole) - top.fraction[k] * strip(upper_next)) *
              normalizer;
  }
}

}  // namespace

void CellGrid::sample_turned(const IntegralImage& integral, float u, float v, float side,
                             float angle) {
  const float along = side * std::cos(angle), across = side * std::sin(angle);
  constexpr float kMiddle = kCells / 2;
  for (int j = 0; j < kCells; ++j) {
    const float row = static_cast<float>(j) - kMiddle;
    average_row(integral, u + 0.5f - 0.5f * side - kMiddle * along - row * across,
                v + 0.5f - 0.5f * side - kMiddle * across + row * along, along, across, side,
                mean[j]);
    for (int k = kCells; k < kPadded; ++k) mean[j][k] = 0;
  }
}

void CellGrid::sample(const IntegralImage& integral, float u, float v, float side) {
  sample_cells(integral, cut_axis(u, side, integral.width()), cut_axis(v, side, integral.height()),
               1.0f / (side * side), mean);
}

}  // namespace eifmap
