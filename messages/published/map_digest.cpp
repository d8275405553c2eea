#include "published/map_digest.h"

#include <array>
#include <cstddef>

namespace eifmap {
namespace {

constexpr std::size_t kLargestEntry = 256;  // bytes

// FNV-1a, whose last bytes hardly reach the upper bits: MurmurHash3's finalizer spreads them, since
// hashes are summed.
std::uint64_t hash(char kind, const std::uint8_t* bytes, std::size_t size) {
  constexpr std::uint64_t kBasis = 0xcbf29ce484222325, kPrime = 0x100000001b3;
  std::uint64_t h = (kBasis ^ static_cast<std::uint8_t>(kind)) * kPrime;
  for (std::size_t i = 0; i < size; ++i) h = (h ^ bytes[i]) * kPrime;
  h = (h ^ h >> 33) * 0xff51afd7ed558ccd;
  h = (h ^ h >> 33) * 0xc4ceb9fe1a85ec53;
  return h ^ h >> 33;
}

template <class Entry>
std::uint64_t hash(char kind, const Entry& entry) {
  std::array<std::uint8_t, kLargestEntry> bytes;
  const int size = entry._encodeNoHash(bytes.data(), 0, static_cast<int>(bytes.size()));
  return hash(kind, bytes.data(), static_cast<std::size_t>(size));
}

}  // namespace

std::uint64_t entry_hash(const keyframe_t& entry) {
  return hash('K', entry);
}
std::uint64_t entry_hash(const landmark_t& entry) {
  return hash('L', entry);
}
std::uint64_t entry_hash(const observation_t& entry) {
  return hash('O', entry);
}

}  // namespace eifmap
