#include "features/descriptor_bytes.h"

#include <algorithm>
#include <cmath>

namespace eifmap {

void write_descriptor(const std::array<double, kDescriptorSize>& values, std::int8_t* descriptor) {
  constexpr double kLargest = 0.5;
  std::array<double, kDescriptorSize> unit = values;
  for (int round = 0; round < 3; ++round) {
    double squares = 0;
    for (const double x : unit) squares += x * x;
    const double factor = squares > 0 ? 1 / std::sqrt(squares) : 0;
    for (double& x : unit) x = std::clamp(x * factor, -kLargest, kLargest);
  }
  for (std::size_t i = 0; i < kDescriptorSize; ++i)
    descriptor[i] = static_cast<std::int8_t>(std::lround(254 * unit[i]));
}

}  // namespace eifmap
