// What poses and statuses say of the published map: how far it has come.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "wire/bytes.h"

namespace eifmap {

struct SaidOfMap {
  std::string camera;
  std::int64_t server_epoch = 0, map_seq = 0;  // as in map_part_t; 0 no map yet
  std::optional<std::int64_t> map_digest;
};

// Of a pose_t, and of a status_t. Refuse with kMalformedMessage what does not fit its own size.
Decoded<SaidOfMap> said_by_pose(Bytes bytes);
Decoded<SaidOfMap> said_by_status(Bytes bytes);

}  // namespace eifmap
