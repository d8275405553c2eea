#include "features/descriptor_bytes.h"

#include <algorithm>
#include <cmath>

#include "vector_clones.h"

namespace eifmap {
namespace {

constexpr int kLanes = 8;

EIFMAP_VECTOR_CLONES
double sum_of_squares(const double* values) {
  alignas(64) double lanes[kLanes] = {};
  for (int i = 0; i < kDescriptorSize; i += kLanes)
    for (int k = 0; k < kLanes; ++k) lanes[k] += values[i + k] * values[i + k];
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) +
         ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

EIFMAP_VECTOR_CLONES
void scale_and_clamp(double factor, double largest, double* values) {
  for (int i = 0; i < kDescriptorSize; ++i)
    values[i] = std::min(std::max(values[i] * factor, -largest), largest);
}

// As std::lround, of numbers that an int holds.
EIFMAP_VECTOR_CLONES
void round_to_bytes(const double* __restrict values, double factor, std::int8_t* __restrict bytes) {
  for (int i = 0; i < kDescriptorSize; ++i) {
    const double x = factor * values[i];
    const int whole = static_cast<int>(x);
    const double rest = x - whole;
    bytes[i] = static_cast<std::int8_t>(whole + (rest >= 0.5) - (rest <= -0.5));
  }
}

}  // namespace

void write_descriptor(const std::array<double, kDescriptorSize>& values, std::int8_t* descriptor) {
  constexpr double kLargest = 0.5;
  std::array<double, kDescriptorSize> unit = values;
  for (int round = 0; round < 3; ++round) {
    const double squares = sum_of_squares(unit.data());
    scale_and_clamp(squares > 0 ? 1 / std::sqrt(squares) : 0, kLargest, unit.data());
  }
  round_to_bytes(unit.data(), 254, descriptor);
}

}  // namespace eifmap
