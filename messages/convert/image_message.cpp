#include "convert/image_message.h"

#include <charconv>

#include "convert/layout.h"
#include "convert/limits.h"

namespace eifmap {
namespace {

using bot_core::image_metadata_t;
using bot_core::image_t;

constexpr const char* kSeqKey = "eifmap.seq";
constexpr const char* kPublisherKey = "eifmap.publisher";
constexpr const char* kCalibrationKey = "eifmap.calibration";

void scan(LayoutScanner& in) {
  in.skip(8 + 4 + 4 + 4 + 4);  // utime, width, height, row_stride, pixelformat
  in.array("data", in.count("size", kMaxMessageBytes), 1);
  const std::size_t n = in.count("nmetadata", kMaxText);
  for (std::size_t i = 0; i < n && in.ok(); ++i) {
    in.string("metadata key", kMaxText);
    in.array("metadata value", in.count("metadata n", kMaxMessageBytes), 1);
  }
}

std::int32_t wire_format(PixelFormat format) {
  if (format == PixelFormat::kMjpeg) return image_t::PIXEL_FORMAT_MJPEG;
  return image_t::PIXEL_FORMAT_GRAY;
}

image_metadata_t metadata(const char* key, std::int64_t number) {
  const std::string text = std::to_string(number);
  image_metadata_t entry;
  entry.key = key;
  entry.value.assign(text.begin(), text.end());
  entry.n = static_cast<std::int32_t>(entry.value.size());
  return entry;
}

// Leaves `number` as it is when the entry is another's; false when it is not a number.
bool read(const image_metadata_t& entry, const char* key, std::int64_t& number) {
  if (entry.key != key) return true;
  const char* begin = reinterpret_cast<const char*>(entry.value.data());
  const char* end = begin + entry.value.size();
  const auto [stop, error] = std::from_chars(begin, end, number);
  return error == std::errc() && stop == end;
}

std::string size_problem(const image_t& message) {
  if (!valid_image_side(message.width) || !valid_image_side(message.height))
    return "width x height is " + std::to_string(message.width) + " x " +
           std::to_string(message.height) + ", each must be 1 to " + std::to_string(kMaxImageSide);
  if (message.pixelformat == image_t::PIXEL_FORMAT_MJPEG) return "";
  const std::int64_t stride = message.row_stride;
  const std::int64_t needed = stride * (message.height - 1) + message.width;
  if (stride < message.width || message.size < needed)
    return std::to_string(message.size) + " bytes with a row_stride of " + std::to_string(stride) +
           " do not hold " + std::to_string(message.width) + " x " +
           std::to_string(message.height) + " pixels";
  return "";
}

}  // namespace

image_t to_message(const ImageMessage& image) {
  image_t message;
  message.utime = image.time_us;
  message.width = image.width;
  message.height = image.height;
  message.row_stride = image.row_stride;
  message.pixelformat = wire_format(image.format);
  message.size = static_cast<std::int32_t>(image.data.size());
  message.data = image.data;
  message.metadata = {metadata(kSeqKey, image.seq), metadata(kPublisherKey, image.publisher),
                      metadata(kCalibrationKey, image.calibration_id)};
  message.nmetadata = static_cast<std::int32_t>(message.metadata.size());
  return message;
}

Decoded<ImageMessage> decode_image(Bytes bytes) {
  using Result = Decoded<ImageMessage>;
  Decoded<image_t> decoded = decode_checked<image_t>(bytes, scan);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  image_t& message = decoded.value;
  if (!valid_time(message.utime))
    return Result::refuse(Reason::kMalformedMessage, "utime is " + std::to_string(message.utime));
  if (message.pixelformat != image_t::PIXEL_FORMAT_GRAY &&
      message.pixelformat != image_t::PIXEL_FORMAT_MJPEG)
    return Result::refuse(Reason::kBadPixelFormat,
                          "pixelformat is " + std::to_string(message.pixelformat));
  if (std::string problem = size_problem(message); !problem.empty())
    return Result::refuse(Reason::kBadImageSize, problem);

  Result result;
  ImageMessage& image = result.value;
  for (const image_metadata_t& entry : message.metadata)
    if (!read(entry, kSeqKey, image.seq) || !read(entry, kPublisherKey, image.publisher) ||
        !read(entry, kCalibrationKey, image.calibration_id))
      return Result::refuse(Reason::kMalformedMessage, entry.key + " is not a decimal number");
  image.time_us = message.utime;
  image.width = message.width;
  image.height = message.height;
  image.row_stride = message.row_stride;
  image.format =
      message.pixelformat == image_t::PIXEL_FORMAT_MJPEG ? PixelFormat::kMjpeg : PixelFormat::kGray;
  image.data = std::move(message.data);
  return result;
}

}  // namespace eifmap
