#include "client/view/picture.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace eifmap {
namespace {

// `image` holds what decode_image() promises of gray pixels.
std::string compress(const ImageMessage& image) {
  const cv::Mat pixels(image.height, image.width, CV_8UC1,
                       const_cast<std::uint8_t*>(image.data.data()),
                       static_cast<std::size_t>(image.row_stride));
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
  } else if (image.format == PixelFormat::kGray) {
    jpeg_ = compress(image);
  } else {
    return;
  }
  ++number_;
}

}  // namespace eifmap
