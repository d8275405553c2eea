// What an extractor gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "frame.h"

namespace eifmap {

// Keypoints and kDescriptorSize int8 per keypoint, in the order and with the very values of the
// wire.
struct Features {
  std::vector<Keypoint> keypoints;
  std::vector<std::int8_t> descriptors;
};

// Indices of the `count` keypoints to keep (see spread), in the wire's order: response falling,
// then v, then u. `width` and `height` of the image, px.
std::vector<std::size_t> best_keypoints(std::span<const Keypoint> keypoints, int width, int height,
                                        std::size_t count);

}  // namespace eifmap
