// The server's state: the wire's own struct, checked.
#pragma once

#include <eifmap/status_t.hpp>

#include "wire/bytes.h"

namespace eifmap {

// Refuses with kMalformedMessage: sizes, state, level or scale out of range. The texts are at most
// 4096 bytes each, of any kind: escape them where they are shown.
Decoded<status_t> decode_status(Bytes bytes);

}  // namespace eifmap
