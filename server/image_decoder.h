// From the bytes of a published image to pixels.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "convert/image_message.h"
#include "geometry/camera.h"

namespace eifmap {

// Smaller ones hold no features.
inline constexpr int kMinImageSide = 32;  // px

struct DecodedImage {
  Reason reason = Reason::kNone;  // kNone: `gray` is valid
  std::string detail;
  cv::Mat gray;  // CV_8UC1, the camera's size

  bool ok() const { return reason == Reason::kNone; }
};

// "" or why features cannot be sought in an image of this size.
std::string size_problem(int width, int height);

// Refuses: kBadImageSize (not the camera's, by the message or by the JPEG's own header, which is
// read before anything is allocated; or too small), kCorruptImage (not a JPEG, or cut off).
// gray16_bits, 8 to 16: how many of LE_GRAY16's the camera fills.
DecodedImage decode_pixels(const ImageMessage& image, const Camera& camera, int gray16_bits = 16);

}  // namespace eifmap
