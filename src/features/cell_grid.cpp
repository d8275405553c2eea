#include "features/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "vector_clones.h"

namespace eifmap {
namespace {

constexpr int kCells = CellGrid::kCells;
constexpr int kPadded = CellGrid::kPadded;

// Where the sides of a row of cells, one after the other, cut one axis of the integral image.
struct Cuts {
  alignas(32) std::int32_t index[kPadded];  // between entries index and index + 1
  alignas(32) float fraction[kPadded];      // outside [0, 1] beyond the image: the border goes on

  void cut(float first, float step, int size) {
    const float last = static_cast<float>(size - 1);
    for (int k = 0; k < kPadded; ++k) {
      const float x = first + static_cast<float>(k) * step;
      index[k] = static_cast<std::int32_t>(std::min(std::max(x, 0.0f), last));
      fraction[k] = x - static_cast<float>(index[k]);
    }
  }
};

// Two neighbouring entries of a row of the integral image per cut. They are read at once, one cut
// after the other: processors do not gather any faster.
struct Pairs {
  alignas(32) std::uint32_t of[kPadded][2];
};

[[gnu::noinline]] void read_pairs(const std::uint32_t* row, const Cuts& cuts, Pairs& pairs) {
  for (int k = 0; k < kPadded; ++k)
    std::memcpy(pairs.of[k], row + cuts.index[k], sizeof pairs.of[k]);
}

// Sums of a row of cells, from rows of the integral image: exact integers until the last step.
struct Line {
  Pairs entries;                                                  // of the upper row
  alignas(32) float left_pixels[kPadded], right_pixels[kPadded];  // what one row of pixels adds
};

EIFMAP_VECTOR_CLONES
void sample_cells(const IntegralImage& integral, const Cuts& columns, const Cuts& rows,
                  float normalizer, float (*mean)[kPadded]) {
  Line lines[2];
  Pairs lower;
  alignas(32) float cut[kPadded];
  for (int j = 0; j <= kCells; ++j) {
    Line& line = lines[j % 2];
    const Line& above = lines[(j + 1) % 2];
    const Pairs& upper = line.entries;
    read_pairs(integral.row(rows.index[j]), columns, line.entries);
    read_pairs(integral.row(rows.index[j] + 1), columns, lower);
    // The pixels of this row left of the grid's first column.
    const std::uint32_t base = lower.of[0][0] - upper.of[0][0];
    for (int k = 0; k < kPadded; ++k) {
      line.left_pixels[k] =
          static_cast<float>(static_cast<std::int32_t>(lower.of[k][0] - upper.of[k][0] - base));
      line.right_pixels[k] =
          static_cast<float>(static_cast<std::int32_t>(lower.of[k][1] - upper.of[k][1] - base));
    }
    if (j == 0) continue;
    const float top = rows.fraction[j - 1], bottom = rows.fraction[j];
    const std::uint32_t first = upper.of[0][0] - above.entries.of[0][0];
    for (int k = 0; k < kPadded; ++k) {
      const float left = static_cast<float>(static_cast<std::int32_t>(
                             upper.of[k][0] - above.entries.of[k][0] - first)) +
                         (bottom * line.left_pixels[k] - top * above.left_pixels[k]);
      const float right = static_cast<float>(static_cast<std::int32_t>(
                              upper.of[k][1] - above.entries.of[k][1] - first)) +
                          (bottom * line.right_pixels[k] - top * above.right_pixels[k]);
      cut[k] = left + columns.fraction[k] * (right - left);
    }
    for (int k = 0; k < kCells; ++k) mean[j - 1][k] = (cut[k + 1] - cut[k]) * normalizer;
  }
}

// What a row of cells reads of one row of the integral image: per cell, the entries at the columns
// that its left and its right side cut, two each.
struct Entries {
  alignas(32) std::uint32_t of[kPadded][4];
};

[[gnu::noinline]] void read_entries(const std::uint32_t* sums, const std::int32_t* offsets,
                                    const Cuts& left, const Cuts& right, Entries& entries) {
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
  Cuts left, right, top, bottom;
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
  // Pixel x covers [x, x + 1) of the integral image's axis: its centre is at x + 0.5.
  constexpr float kHalf = 0.5f * kCells;
  Cuts columns, rows;
  columns.cut(u + 0.5f - kHalf * side, side, integral.width());
  rows.cut(v + 0.5f - kHalf * side, side, integral.height());
  sample_cells(integral, columns, rows, 1.0f / (side * side), mean);
}

}  // namespace eifmap
