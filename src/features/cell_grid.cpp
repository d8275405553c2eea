#include "features/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

// Where one side of each cell of a row cuts an axis.
EIFMAP_VECTOR_CLONES
void cut_cells(float first, float step, int size, Cuts& cuts) {
  const float last = static_cast<float>(size - 1);
  for (int k = 0; k < kPadded; ++k) {
    const float x = first + static_cast<float>(k) * step;
    const float index = std::min(std::max(std::floor(x), 0.0f), last);
    cuts.index[k] = static_cast<std::int32_t>(index);
    cuts.fraction[k] = x - index;
  }
}

// Pixel sums of boxes that begin at the first pixel that the cell cuts: exact integers, relative to
// the first row and column.
struct Corner {
  const std::uint32_t* sums;
  std::ptrdiff_t stride;

  float inside(std::int32_t left, std::int32_t top, std::int32_t x, std::int32_t y) const {
    const std::uint32_t* upper = sums + top * stride;
    const std::uint32_t* lower = sums + y * stride;
    return static_cast<float>(
        static_cast<std::int32_t>((lower[x] - lower[left]) - (upper[x] - upper[left])));
  }
};

// One row of a turned grid.
EIFMAP_VECTOR_CLONES
void average_row(const IntegralImage& integral, const Cuts& left, const Cuts& right,
                 const Cuts& top, const Cuts& bottom, float normalizer, float* mean) {
  const Corner corner{integral.row(0), integral.width() + 1};
  for (int k = 0; k < kCells; ++k) {
    const std::int32_t x0 = left.index[k], x1 = right.index[k];
    const std::int32_t y0 = top.index[k], y1 = bottom.index[k];
    const auto sum = [&](std::int32_t x, std::int32_t y) { return corner.inside(x0, y0, x, y); };
    const float fx0 = left.fraction[k], fx1 = right.fraction[k];
    // From the first pixel's left side to the cell's right side, minus to the cell's left side.
    const auto strip = [&](std::int32_t y) {
      const float until_right = sum(x1, y) + fx1 * (sum(x1 + 1, y) - sum(x1, y));
      return until_right - fx0 * sum(x0 + 1, y);
    };
    const float until_bottom = strip(y1) + bottom.fraction[k] * (strip(y1 + 1) - strip(y1));
    mean[k] = (until_bottom - top.fraction[k] * strip(y0 + 1)) * normalizer;
  }
}

}  // namespace

void CellGrid::sample_turned(const IntegralImage& integral, float u, float v, float side,
                             float angle) {
  const float along = side * std::cos(angle), across = side * std::sin(angle);
  constexpr float kMiddle = kCells / 2;
  Cuts left, right, top, bottom;
  for (int j = 0; j < kCells; ++j) {
    const float row = static_cast<float>(j) - kMiddle;
    const float x = u + 0.5f - 0.5f * side - kMiddle * along - row * across;
    const float y = v + 0.5f - 0.5f * side - kMiddle * across + row * along;
    cut_cells(x, along, integral.width(), left);
    cut_cells(x + side, along, integral.width(), right);
    cut_cells(y, across, integral.height(), top);
    cut_cells(y + side, across, integral.height(), bottom);
    average_row(integral, left, right, top, bottom, 1.0f / (side * side), mean[j]);
  }
}

void CellGrid::sample(const IntegralImage& integral, float u, float v, float side) {
  sample_cells(integral, cut_axis(u, side, integral.width()), cut_axis(v, side, integral.height()),
               1.0f / (side * side), mean);
}

}  // namespace eifmap
