// A map as a pose graph, for the start that a closed loop gives its filter.
#pragma once

#include "map/loop_gate.h"
#include "map/map.h"
#include "map/pose_graph.h"

namespace eifmap {

// Keyframes as they are, tied to those that they share landmarks with as they now are to each
// other, and the loop. The first two are held: they are the map's gauge. Nothing of it is
// information: it would count what the filter has already, a second time.
PoseGraph graph_with_loop(const Map& map, const LoopFit& loop);

}  // namespace eifmap
