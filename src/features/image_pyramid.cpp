#include "features/image_pyramid.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "vector_clones.h"

namespace eifmap {
namespace {

EIFMAP_VECTOR_CLONES
void to_floats(const std::uint8_t* __restrict from, int count, float* __restrict to) {
  for (int x = 0; x < count; ++x) to[x] = static_cast<float>(from[x]) * (1.0f / 255.0f);
}

// Weights 1 3 3 1 down the columns, then along the row.
EIFMAP_VECTOR_CLONES
void halve(const float* __restrict a, const float* __restrict b, const float* __restrict c,
           const float* __restrict d, int count, float* __restrict column, float* __restrict to) {
  for (int x = 0; x < 2 * count + 2; ++x)
    column[x] = (a[x - 1] + d[x - 1]) + 3.0f * (b[x - 1] + c[x - 1]);
  for (int x = 0; x < count; ++x) {
    const float* at = column + std::ptrdiff_t{2} * x;
    to[x] = (1.0f / 64) * ((at[0] + at[3]) + 3.0f * (at[1] + at[2]));
  }
}

}  // namespace

void ImagePyramid::resize(Level& level, int width, int height) {
  level.width = width;
  level.height = height;
  level.pixels.resize(static_cast<std::size_t>(level.stride()) *
                      static_cast<std::size_t>(height + 2 * kBorder));
}

void ImagePyramid::pad(Level& level) {
  for (int y = 0; y < level.height; ++y) {
    float* row = level.row(y);
    std::fill(row - kBorder, row, row[0]);
    std::fill(row + level.width, row + level.width + kBorder, row[level.width - 1]);
  }
  for (int y = 1; y <= kBorder; ++y) {
    std::copy_n(level.row(0) - kBorder, level.stride(), level.row(-y) - kBorder);
    std::copy_n(level.row(level.height - 1) - kBorder, level.stride(),
                level.row(level.height - 1 + y) - kBorder);
  }
}

void ImagePyramid::assign(const cv::Mat& gray, int levels) {
  if (gray.type() != CV_8UC1 || gray.empty())
    throw std::invalid_argument("image pyramid: the image must be CV_8UC1 and not empty");
  std::size_t count = 1;
  for (int size = std::min(gray.cols, gray.rows); size >= 2 && static_cast<int>(count) < levels;
       size /= 2)
    ++count;
  levels_.resize(count);
  resize(levels_[0], gray.cols, gray.rows);
  for (int y = 0; y < gray.rows; ++y)
    to_floats(gray.ptr<std::uint8_t>(y), gray.cols, levels_[0].row(y));
  pad(levels_[0]);
  column_.resize(static_cast<std::size_t>(gray.cols) + 2);
  for (std::size_t k = 1; k < count; ++k) {
    const Level& fine = levels_[k - 1];
    Level& coarse = levels_[k];
    resize(coarse, fine.width / 2, fine.height / 2);
    for (int y = 0; y < coarse.height; ++y)
      halve(fine.row(2 * y - 1), fine.row(2 * y), fine.row(2 * y + 1), fine.row(2 * y + 2),
            coarse.width, column_.data(), coarse.row(y));
    pad(coarse);
  }
}

}  // namespace eifmap
