// An image: image_t <-> its fields, pixels still as they came.
#pragma once

#include <bot_core/image_t.hpp>

#include "convert/bytes.h"

namespace eifmap {

enum class PixelFormat { kGray, kMjpeg };

struct ImageMessage {
  std::int64_t time_us = 0;         // capture, publisher's clock
  std::int64_t publisher = 0;       // from the metadata, as the next two; 0 unknown
  std::int64_t seq = -1;            // -1 unknown
  std::int64_t calibration_id = 0;  // 0 unknown
  int width = 0, height = 0;        // px
  int row_stride = 0;               // bytes, >= width for kGray
  PixelFormat format = PixelFormat::kGray;
  std::vector<std::uint8_t> data;  // kGray: row_stride * height bytes, at least
};

bot_core::image_t to_message(const ImageMessage& image);

// Refuses: kMalformedMessage (sizes, time, metadata), kBadPixelFormat, kBadImageSize (sides, or
// fewer bytes than they need).
Decoded<ImageMessage> decode_image(Bytes bytes);

}  // namespace eifmap
