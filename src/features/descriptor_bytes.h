// Descriptors as the wire carries them.
#pragma once

#include <array>
#include <cstdint>

#include "frame.h"

namespace eifmap {

// To unit length with no entry over 0.5, as far as both can be had, then round(254 x); all 0 stays.
// Writes kDescriptorSize bytes.
void write_descriptor(const std::array<double, kDescriptorSize>& values, std::int8_t* descriptor);

}  // namespace eifmap
