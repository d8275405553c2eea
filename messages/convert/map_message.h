// Map updates: MapUpdate -> the wire's values.
#pragma once

#include <eifmap/map_part_t.hpp>

#include "convert/pose_message.h"
#include "map_view.h"

namespace eifmap {

// All of it as one part, without a digest. `time_us`: of the image that gave the update.
map_part_t to_message(const MapUpdate& update, const Origin& origin, std::int64_t time_us);

}  // namespace eifmap
