#include "server/image_decoder.h"

#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "convert/gray_pixels.h"

namespace eifmap {
namespace {

DecodedImage refuse(Reason reason, std::string detail) {
  return {reason, std::move(detail), {}};
}

struct JpegSize {
  int width = 0, height = 0;
};

int big_endian_16(Bytes bytes, std::size_t at) {
  return bytes[at] << 8 | bytes[at + 1];
}

// From the frame header (SOF0 to SOF15), found by walking over the segments before it.
std::optional<JpegSize> jpeg_size(Bytes bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return {};
  std::size_t at = 2;
  while (at + 9 <= bytes.size() && bytes[at] == 0xff) {
    const int marker = bytes[at + 1];
    if (marker == 0xff) {  // a fill byte
      ++at;
      continue;
    }
    const bool frame_header =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame_header) return JpegSize{big_endian_16(bytes, at + 7), big_endian_16(bytes, at + 5)};
    const int length = big_endian_16(bytes, at + 2);
    if (length < 2) return {};
    at += 2 + static_cast<std::size_t>(length);
  }
  return {};
}

// Cameras pad with zeros after the end marker.
bool ends_as_jpeg(Bytes bytes) {
  while (!bytes.empty() && bytes.back() == 0) bytes = bytes.first(bytes.size() - 1);
  return bytes.size() >= 2 && bytes[bytes.size() - 2] == 0xff && bytes.back() == 0xd9;
}

std::string text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

DecodedImage decode_jpeg(const ImageMessage& image, const Camera& camera) {
  const std::optional<JpegSize> size = jpeg_size(image.data);
  if (!size) return refuse(Reason::kCorruptImage, "no JPEG header");
  if (size->width != camera.width || size->height != camera.height)
    return refuse(Reason::kBadImageSize, "the JPEG is " + text(size->width, size->height) +
                                             ", the calibration " +
                                             text(camera.width, camera.height));
  if (!ends_as_jpeg(image.data)) return refuse(Reason::kCorruptImage, "the JPEG is cut off");
  DecodedImage decoded;
  try {
    decoded.gray = cv::imdecode(image.data, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    // Told below: no pixels.
  }
  if (decoded.gray.cols != camera.width || decoded.gray.rows != camera.height)
    return refuse(Reason::kCorruptImage, "the JPEG cannot be decoded");
  return decoded;
}

}  // namespace

std::string size_problem(int width, int height) {
  if (width >= kMinImageSide && height >= kMinImageSide) return "";
  return "the image is " + text(width, height) + ", wanted at least " +
         text(kMinImageSide, kMinImageSide);
}

DecodedImage decode_pixels(const ImageMessage& image, const Camera& camera, int gray16_bits) {
  if (image.width != camera.width || image.height != camera.height)
    return refuse(Reason::kBadImageSize, "the image is " + text(image.width, image.height) +
                                             ", the calibration " +
                                             text(camera.width, camera.height));
  if (std::string problem = size_problem(image.width, image.height); !problem.empty())
    return refuse(Reason::kBadImageSize, std::move(problem));
  if (image.format == PixelFormat::kMjpeg) return decode_jpeg(image, camera);
  DecodedImage decoded;
  decoded.gray = gray_pixels(image, gray16_bits);
  return decoded;
}

}  // namespace eifmap
