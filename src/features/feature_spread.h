// Which features to keep when there are more than wanted.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace eifmap {

struct Contender {
  float u = 0, v = 0;  // px
  float response = 0;  // > 0
  int sign = 0;
};

// Indices of the `count` contenders to keep, best first. The image is cut into square tiles; within
// a tile and sign, the n-th strongest counts as if its response were divided by n: strong texture
// still gets more, but weak regions keep their best. Equal contenders stay in the order given.
std::vector<std::size_t> spread(std::span<const Contender> contenders, int width, int height,
                                std::size_t count);

}  // namespace eifmap
