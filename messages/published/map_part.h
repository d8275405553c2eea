// Map updates as parts that each fit one datagram, and back.
#pragma once

#include <cstddef>
#include <eifmap/map_part_t.hpp>
#include <vector>

#include "wire/bytes.h"

namespace eifmap {

inline constexpr std::size_t kMinPartBytes = 512;

// The parts of an update that is in one, each of an encoded size of at most max_part_bytes; one
// part when there is nothing to say. Throws std::invalid_argument when max_part_bytes is below
// kMinPartBytes.
std::vector<map_part_t> split(const map_part_t& update, std::size_t max_part_bytes);

// Puts a part's entries behind those of `whole`.
void append(const map_part_t& part, map_part_t& whole);

// Refuses with kMalformedMessage: sizes, names, times, numbers, poses, positions and covariances
// that are none.
Decoded<map_part_t> decode_map_part(Bytes bytes);

}  // namespace eifmap
