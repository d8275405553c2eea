#include "features/integral_image.h"

#include <algorithm>
#include <stdexcept>

namespace eifmap {

void IntegralImage::assign(const cv::Mat& gray) {
  if (gray.type() != CV_8UC1 || gray.empty())
    throw std::invalid_argument("integral image: the image must be CV_8UC1 and not empty");
  width_ = gray.cols;
  height_ = gray.rows;
  const std::size_t stride = static_cast<std::size_t>(width_) + 1;
  sums_.resize(stride * (static_cast<std::size_t>(height_) + 1));
  std::fill_n(sums_.begin(), stride, 0u);
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* pixels = gray.ptr<std::uint8_t>(y);
    const std::uint32_t* above = row(y);
    std::uint32_t* sums = sums_.data() + stride * (static_cast<std::size_t>(y) + 1);
    std::uint32_t left = 0;
    sums[0] = 0;
    for (int x = 0; x < width_; ++x) {
      left += pixels[x];
      sums[x + 1] = above[x + 1] + left;
    }
  }
}

}  // namespace eifmap
