// The image at full, half, quarter, ... size: each level the mean of 2x2 pixels of the one before.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace eifmap {

// Pixel (x, y) of level k is centred on pixel ((x + .5) 2^k - .5, (y + .5) 2^k - .5) of the image.
class ImagePyramid {
 public:
  static constexpr int kBorder = 24;  // px on each side, copies of the outermost pixels

  ImagePyramid() = default;
  ImagePyramid(const cv::Mat& gray, int levels) { assign(gray, levels); }

  // CV_8UC1, std::invalid_argument on another type; intensities in [0, 1]. At most `levels`. Memory
  // of an earlier image is used again.
  void assign(const cv::Mat& gray, int levels);

  int levels() const { return static_cast<int>(levels_.size()); }
  int width(int level) const { return levels_[static_cast<std::size_t>(level)].width; }
  int height(int level) const { return levels_[static_cast<std::size_t>(level)].height; }

  // Row y in [-kBorder, height + kBorder); entries [-kBorder, width + kBorder) are there.
  const float* row(int level, int y) const {
    return levels_[static_cast<std::size_t>(level)].row(y);
  }

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<float> pixels;

    int stride() const { return width + 2 * kBorder; }
    float* row(int y) {
      return pixels.data() + static_cast<std::ptrdiff_t>(y + kBorder) * stride() + kBorder;
    }
    const float* row(int y) const { return const_cast<Level*>(this)->row(y); }
  };

  static void resize(Level& level, int width, int height);
  static void pad(Level& level);

  std::vector<Level> levels_;
  std::vector<float> column_;  // scratch
};

}  // namespace eifmap
