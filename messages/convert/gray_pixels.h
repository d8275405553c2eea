// The gray values of an image that is not compressed.
#pragma once

#include <opencv2/core.hpp>

#include "convert/image_message.h"

namespace eifmap {

// CV_8UC1, width x height, of what decode_image() let through; of a luma plane its values as they
// are. Empty for kMjpeg. gray16_bits, 8 to 16: how many of kGray16's the camera fills; what is more
// is white.
cv::Mat gray_pixels(const ImageMessage& image, int gray16_bits);

}  // namespace eifmap
