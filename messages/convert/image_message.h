// An image: image_t <-> its fields, pixels still as they came.
#pragma once

#include <bot_core/image_t.hpp>

#include "wire/bytes.h"

namespace eifmap {

enum class PixelFormat {
  kGray,    // 8 bits
  kGray16,  // 16 bits, little-endian
  kRgb,
  kBgr,
  kRgba,
  kBgra,
  kYuyv,  // of 2 bytes a pixel, the first is its luma
  kUyvy,  // ... the second
  kI420,  // a plane of luma, then planes of less
  kNv12,
  kMjpeg,
};

// What a format asks of a message, and its name: all that knows the wire's numbers.
struct PixelFormatInfo {
  PixelFormat format;
  std::int32_t wire;
  int bytes_per_pixel;  // of a row of the first plane; 0: compressed
  const char* name;
};
const PixelFormatInfo& format_info(PixelFormat format);

struct ImageMessage {
  std::int64_t time_us = 0;         // capture, publisher's clock
  std::int64_t publisher = 0;       // from the metadata, as the next two; 0 unknown
  std::int64_t seq = -1;            // -1 unknown
  std::int64_t calibration_id = 0;  // 0 unknown
  int width = 0, height = 0;        // px
  int row_stride = 0;               // bytes, at least a row's; 0 when compressed
  PixelFormat format = PixelFormat::kGray;
  std::vector<std::uint8_t> data;  // row_stride * (height - 1) bytes and a row, at least
};

bot_core::image_t to_message(const ImageMessage& image);

// A row_stride of 0 is taken for rows without padding: many drivers leave it out. Refuses:
// kMalformedMessage (sizes, time, metadata), kBadPixelFormat, kBadImageSize (sides, or fewer bytes
// than they need).
Decoded<ImageMessage> decode_image(Bytes bytes);

}  // namespace eifmap
