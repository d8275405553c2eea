// What of a map is made when somebody asks for it.
#pragma once

#include <cstdint>
#include <optional>

#include "map/map.h"
#include "map_view.h"

namespace eifmap {

// See Mapper::relative_pose() and in_earth().
std::optional<RelativeView> relative_view(const Map& map, std::int64_t a, std::int64_t b);
std::optional<EarthView> earth_view(const Map& map);

}  // namespace eifmap
