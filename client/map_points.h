// A published map as points.
#pragma once

#include <vector>

#include "map_view.h"
#include "published/published_map.h"

namespace eifmap {

// In the map's frame, by landmark. Those whose anchor is not in the map are left out.
std::vector<MapPoint> points_of(const PublishedMap& map);

}  // namespace eifmap
