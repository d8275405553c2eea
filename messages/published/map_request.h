// What a client asks for that did not arrive: map_request_t.
#pragma once

#include <cstdint>
#include <eifmap/map_request_t.hpp>

#include "wire/bytes.h"

namespace eifmap {

// In one request; what is missing beyond that is asked for in the next.
inline constexpr std::size_t kMaxMissing = 1024;
inline constexpr std::int32_t kAllParts = -1;

std::int64_t random_requester();  // not 0

// Refuses with kMalformedMessage: sizes, name, time, a requester that is 0, numbers that are none.
Decoded<map_request_t> decode_map_request(Bytes bytes);

}  // namespace eifmap
