#include "convert/gray_pixels.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace eifmap {
namespace {

// The message's pixels where they are; not to be written to.
cv::Mat pixels_of(const ImageMessage& image, int channels) {
  return {image.height, image.width, CV_8UC(channels), const_cast<std::uint8_t*>(image.data.data()),
          static_cast<std::size_t>(image.row_stride)};
}

// The upper 8 of the bits that the camera fills. Too large a value, of a camera with more bits than
// was said, is white.
cv::Mat from_gray16(const ImageMessage& image, int bits) {
  cv::Mat gray(image.height, image.width, CV_8UC1);
  for (int row = 0; row < image.height; ++row) {
    const std::uint8_t* from = image.data.data() + static_cast<std::size_t>(row) *
                                                       static_cast<std::size_t>(image.row_stride);
    std::uint8_t* to = gray.ptr(row);
    for (int x = 0; x < image.width; ++x)
      to[x] = static_cast<std::uint8_t>(
          std::min(255, (from[2 * x] | from[2 * x + 1] << 8) >> (bits - 8)));
  }
  return gray;
}

}  // namespace

cv::Mat gray_pixels(const ImageMessage& image, int gray16_bits) {
  cv::Mat gray;
  switch (image.format) {
    case PixelFormat::kGray:
    case PixelFormat::kI420:
    case PixelFormat::kNv12:
      pixels_of(image, 1).copyTo(gray);
      break;
    case PixelFormat::kGray16:
      gray = from_gray16(image, gray16_bits);
      break;
    case PixelFormat::kRgb:
      cv::cvtColor(pixels_of(image, 3), gray, cv::COLOR_RGB2GRAY);
      break;
    case PixelFormat::kBgr:
      cv::cvtColor(pixels_of(image, 3), gray, cv::COLOR_BGR2GRAY);
      break;
    case PixelFormat::kRgba:
      cv::cvtColor(pixels_of(image, 4), gray, cv::COLOR_RGBA2GRAY);
      break;
    case PixelFormat::kBgra:
      cv::cvtColor(pixels_of(image, 4), gray, cv::COLOR_BGRA2GRAY);
      break;
    case PixelFormat::kYuyv:
      cv::extractChannel(pixels_of(image, 2), gray, 0);
      break;
    case PixelFormat::kUyvy:
      cv::extractChannel(pixels_of(image, 2), gray, 1);
      break;
    case PixelFormat::kMjpeg:
      break;
  }
  return gray;
}

}  // namespace eifmap
