#include "convert/image_message.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "wire/layout.h"
#include "wire/limits.h"

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

// In the order of the enumerators.
constexpr std::array kFormats{
    PixelFormatInfo{PixelFormat::kGray, image_t::PIXEL_FORMAT_GRAY, 1, "GRAY"},
    PixelFormatInfo{PixelFormat::kGray16, image_t::PIXEL_FORMAT_LE_GRAY16, 2, "LE_GRAY16"},
    PixelFormatInfo{PixelFormat::kRgb, image_t::PIXEL_FORMAT_RGB, 3, "RGB"},
    PixelFormatInfo{PixelFormat::kBgr, image_t::PIXEL_FORMAT_BGR, 3, "BGR"},
    PixelFormatInfo{PixelFormat::kRgba, image_t::PIXEL_FORMAT_RGBA, 4, "RGBA"},
    PixelFormatInfo{PixelFormat::kBgra, image_t::PIXEL_FORMAT_BGRA, 4, "BGRA"},
    PixelFormatInfo{PixelFormat::kYuyv, image_t::PIXEL_FORMAT_YUYV, 2, "YUYV"},
    PixelFormatInfo{PixelFormat::kUyvy, image_t::PIXEL_FORMAT_UYVY, 2, "UYVY"},
    PixelFormatInfo{PixelFormat::kI420, image_t::PIXEL_FORMAT_I420, 1, "I420"},
    PixelFormatInfo{PixelFormat::kNv12, image_t::PIXEL_FORMAT_NV12, 1, "NV12"},
    PixelFormatInfo{PixelFormat::kMjpeg, image_t::PIXEL_FORMAT_MJPEG, 0, "MJPEG"}};

const PixelFormatInfo* find_format(std::int32_t wire) {
  const auto found = std::find_if(kFormats.begin(), kFormats.end(),
                                  [wire](const PixelFormatInfo& f) { return f.wire == wire; });
  return found == kFormats.end() ? nullptr : &*found;
}

std::string format_problem(std::int32_t wire) {
  std::string problem = "pixelformat is " + std::to_string(wire) + ", wanted one of";
  for (const PixelFormatInfo& format : kFormats)
    problem += std::string(" ") + format.name + " (" + std::to_string(format.wire) + ")";
  return problem;
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

std::string size_problem(const image_t& message, const PixelFormatInfo& format) {
  if (!valid_image_side(message.width) || !valid_image_side(message.height))
    return "width x height is " + std::to_string(message.width) + " x " +
           std::to_string(message.height) + ", each must be 1 to " + std::to_string(kMaxImageSide);
  if (format.bytes_per_pixel == 0) return "";
  const std::int64_t row = std::int64_t{format.bytes_per_pixel} * message.width;
  const std::int64_t stride = message.row_stride;
  if (stride < row || message.size < stride * (message.height - 1) + row)
    return std::to_string(message.size) + " bytes with a row_stride of " + std::to_string(stride) +
           " do not hold " + std::to_string(message.width) + " x " +
           std::to_string(message.height) + " pixels of " + format.name;
  return "";
}

}  // namespace

const PixelFormatInfo& format_info(PixelFormat format) {
  return kFormats[static_cast<std::size_t>(format)];
}

image_t to_message(const ImageMessage& image) {
  image_t message;
  message.utime = image.time_us;
  message.width = image.width;
  message.height = image.height;
  message.row_stride = image.row_stride;
  message.pixelformat = format_info(image.format).wire;
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
  const PixelFormatInfo* format = find_format(message.pixelformat);
  if (!format) return Result::refuse(Reason::kBadPixelFormat, format_problem(message.pixelformat));
  if (message.row_stride == 0 && valid_image_side(message.width))
    message.row_stride = format->bytes_per_pixel * message.width;
  if (std::string problem = size_problem(message, *format); !problem.empty())
    return Result::refuse(Reason::kBadImageSize, problem);

  Result result;
  ImageMessage& image = result.value;
  for (const image_metadata_t& entry : message.metadata)
    if (!read(entry, kSeqKey, image.seq) || !read(entry, kPublisherKey, image.publisher) ||
        !read(entry, kCalibrationKey, image.calibration_id))
      return Result::refuse(Reason::kMalformedMessage, entry.key + " is not a decimal number");
  if (!valid_seq(image.seq))
    return Result::refuse(Reason::kMalformedMessage, "seq is " + std::to_string(image.seq));
  image.time_us = message.utime;
  image.width = message.width;
  image.height = message.height;
  image.row_stride = message.row_stride;
  image.format = format->format;
  image.data = std::move(message.data);
  return result;
}

}  // namespace eifmap
