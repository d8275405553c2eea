#include "storage/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace eifmap {

std::uint64_t hash_bytes(std::span<const std::uint8_t> bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

}  // namespace eifmap
