// Landmarks of a place that turn out to be those of another pass of it.
#pragma once

#include <vector>

#include "map/map.h"
#include "map/tracking.h"
#include "options.h"

namespace eifmap {

// The features that `newest` sees are these landmarks; returns how many tracks were joined or
// extended.
int join_sights(Map& map, int newest, const std::vector<LandmarkSight>& sights);

// The same of what keyframes of the one pass should see of the other, and do: looked for around
// where the map, which is bent already, predicts it. `here`, `there`: keyframes.
int join_passes(Map& map, const std::vector<int>& here, const std::vector<int>& there,
                const MapperOptions& options);

}  // namespace eifmap
