#include "client/view/picture.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "convert/gray_pixels.h"

namespace eifmap {
namespace {

// Of 16-bit pixels, as many as the brightest one needs: nobody has told the view how many the
// camera fills.
int bits_in_use(const ImageMessage& image) {
  int highest = 0;
  for (int row = 0; row < image.height; ++row) {
    const std::uint8_t* from = image.data.data() + static_cast<std::size_t>(row) *
                                                       static_cast<std::size_t>(image.row_stride);
    for (int x = 0; x < image.width; ++x)
      highest = std::max(highest, from[2 * x] | from[2 * x + 1] << 8);
  }
  int bits = 8;
  while (highest >> bits != 0) ++bits;
  return bits;
}

std::string compress(const ImageMessage& image) {
  const cv::Mat pixels =
      gray_pixels(image, image.format == PixelFormat::kGray16 ? bits_in_use(image) : 16);
  const double scale =
      std::min(1.0, static_cast<double>(Picture::kMaxSide) / std::max(image.width, image.height));
  cv::Mat small;
  const cv::Size size(std::max(1, cvRound(scale * image.width)),
                      std::max(1, cvRound(scale * image.height)));
  cv::resize(pixels, small, size, 0, 0, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 80});
  return {bytes.begin(), bytes.end()};
}

}  // namespace

void Picture::take(const ImageMessage& image) {
  if (image.format == PixelFormat::kMjpeg) {
    if (image.data.size() > kMaxJpegBytes) return;
    jpeg_.assign(image.data.begin(), image.data.end());
  } else {
    jpeg_ = compress(image);
  }
  ++number_;
}

void Picture::clear() {
  if (jpeg_.empty()) return;
  jpeg_.clear();
  ++number_;
}

}  // namespace eifmap
