#include "features/image_pyramid.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "features/vector_clones.h"

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

ImagePyramid::Level ImagePyramid::empty_level(int width, int height) {
  Level level{.width = width, .height = height, .pixels = {}};
  level.pixels.resize(static_cast<std::size_t>(level.stride()) *
                      static_cast<std::size_t>(height + 2 * kBorder));
  return level;
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

ImagePyramid::ImagePyramid(const cv::Mat& gray, int levels) {
  if (gray.type() != CV_8UC1 || gray.empty())
    throw std::invalid_argument("image pyramid: the image must be CV_8UC1 and not empty");
  levels_.push_back(empty_level(gray.cols, gray.rows));
  for (int y = 0; y < gray.rows; ++y)
    to_floats(gray.ptr<std::uint8_t>(y), gray.cols, levels_[0].row(y));
  pad(levels_[0]);
  std::vector<float> column(static_cast<std::size_t>(gray.cols) + 2);
  for (int k = 1; k < levels; ++k) {
    const Level& fine = levels_.back();
    if (fine.width < 2 || fine.height < 2) break;
    Level coarse = empty_level(fine.width / 2, fine.height / 2);
    for (int y = 0; y < coarse.height; ++y)
      halve(fine.row(2 * y - 1), fine.row(2 * y), fine.row(2 * y + 1), fine.row(2 * y + 2),
            coarse.width, column.data(), coarse.row(y));
    pad(coarse);
    levels_.push_back(std::move(coarse));
  }
}

}  // namespace eifmap
