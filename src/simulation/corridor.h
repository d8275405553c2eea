// The world `corridor`: indoors, 2.4 m wide, 2.7 m high and 63 m long; every 4.2 m the same doors,
// boards, radiators and lamps, on the same walls and tiles. Its ends alone differ.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/scene.h"
#include "simulation/walk.h"

namespace eifmap::simulation {

std::vector<Quad> corridor(std::uint32_t seed);

// Near its southern end, to the north.
Walk walk_down_the_corridor();

}  // namespace eifmap::simulation
