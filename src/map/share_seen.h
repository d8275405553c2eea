// Whether a place is that of a map, by what of the map should be seen there: places that only have
// something in common differ in the rest.
#pragma once

#include "map/map.h"
#include "map/sight_counts.h"
#include "options.h"

namespace eifmap {

// Of the landmarks around `keyframe` that the map has seen well and that the camera should see from
// the pose, the share that was observed there; 0 where it should see none. About 1 where all is as
// it was, but for what the detector misses.
double share_seen(const Map& map, int keyframe, const ObservedFrame& observed,
                  const Rigid3& world_from_camera, const SafeView& view,
                  const MapperOptions& options);

}  // namespace eifmap
