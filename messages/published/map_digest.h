// What stands for the contents of a published map: a sum, so that it follows each change and does
// not depend on any order. How to compute it in another language is said in messages/README.md.
#pragma once

#include <cstdint>
#include <eifmap/keyframe_t.hpp>
#include <eifmap/landmark_t.hpp>
#include <eifmap/observation_t.hpp>

namespace eifmap {

// Of an entry's kind and its bytes as LCM encodes them. A map's digest is the sum of its entries'
// hashes modulo 2^64.
std::uint64_t entry_hash(const keyframe_t& entry);
std::uint64_t entry_hash(const landmark_t& entry);
std::uint64_t entry_hash(const observation_t& entry);

}  // namespace eifmap
