// Sums of image boxes of any size in four reads.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace eifmap {

// at(x, y) is the sum of the pixels left of column x and above row y, modulo 2^32: differences that
// make a box's sum are right as long as that sum is below 2^31, however large the image.
class IntegralImage {
 public:
  IntegralImage() = default;
  explicit IntegralImage(const cv::Mat& gray) { assign(gray); }

  // CV_8UC1; std::invalid_argument on another type. Memory of an earlier image is used again.
  void assign(const cv::Mat& gray);

  int width() const { return width_; }    // px, of the image
  int height() const { return height_; }  // px, of the image

  // Row y in [0, height]; width + 1 entries.
  const std::uint32_t* row(int y) const {
    return sums_.data() + static_cast<std::size_t>(y) * (static_cast<std::size_t>(width_) + 1);
  }
  std::uint32_t at(int x, int y) const { return row(y)[x]; }

  // Sum of the pixels of columns [x0, x1) and rows [y0, y1), inside the image.
  std::int32_t box(int x0, int y0, int x1, int y1) const {
    return static_cast<std::int32_t>(at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0));
  }

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::uint32_t> sums_;  // (height + 1) x (width + 1), row-major
};

}  // namespace eifmap
