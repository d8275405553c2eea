// The checksums of files.
#pragma once

#include <cstdint>
#include <span>

namespace eifmap {

// XXH3, 64 bits.
std::uint64_t hash_bytes(std::span<const std::uint8_t> bytes, std::uint64_t seed);

}  // namespace eifmap
