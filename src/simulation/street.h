// The world `street`: 200 m to the north, 16 m from house to house; parked cars and trees on both
// sides, and a house that closes its end.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/scene.h"

namespace eifmap::simulation {

std::vector<Quad> street(std::uint32_t seed);

}  // namespace eifmap::simulation
