// The newest image as a small JPEG for the pages.
#pragma once

#include <cstdint>
#include <string>

#include "convert/image_message.h"

namespace eifmap {

class Picture {
 public:
  static constexpr int kMaxSide = 480;                   // px, of pixels compressed here
  static constexpr std::size_t kMaxJpegBytes = 1 << 20;  // of a JPEG passed on as it came

  // Pixels are scaled down and compressed, in gray. A JPEG goes on as it came: nothing is decoded
  // here, that is the browser's; a larger one than kMaxJpegBytes is left out.
  void take(const ImageMessage& image);

  // There is none any more.
  void clear();

  const std::string& jpeg() const { return jpeg_; }  // "" for none
  std::int64_t number() const { return number_; }    // +1 per picture, and where it is cleared

 private:
  std::string jpeg_;
  std::int64_t number_ = 0;
};

}  // namespace eifmap
