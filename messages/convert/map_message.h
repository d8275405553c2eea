// Map updates: MapUpdate <-> map_part_t, in parts that each fit one datagram.
#pragma once

#include <eifmap/map_part_t.hpp>

#include "convert/bytes.h"
#include "convert/pose_message.h"
#include "map_view.h"

namespace eifmap {

inline constexpr std::size_t kMinPartBytes = 512;

struct MapPart {
  Origin origin;
  std::int64_t time_us = 0;  // of the image that gave the update
  int part = 0, num_parts = 1;
  MapUpdate update;  // this part's share of the entries
};

// The parts of an update, each of an encoded size of at most max_part_bytes; one part when there is
// nothing in it. Throws std::invalid_argument when max_part_bytes < kMinPartBytes.
std::vector<MapPart> split_update(const MapUpdate& update, const Origin& origin,
                                  std::int64_t time_us, std::size_t max_part_bytes);

map_part_t to_message(const MapPart& part);

// Refuses with kMalformedMessage: sizes, name, time, part not below num_parts, seq not above
// base_seq, poses and positions that are not finite or not rotations, landmarks without a sign.
Decoded<MapPart> decode_map_part(Bytes bytes);

}  // namespace eifmap
