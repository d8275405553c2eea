// The world `courtyard`: four wings around a paved yard of 24 m x 18 m, a portico with
// pillars, a fountain in the middle; columns, crates, hedges and benches along the way.
#pragma once

#include <vector>

#include "simulation/scene.h"

namespace eifmap::simulation {

std::vector<Quad> courtyard(std::uint32_t seed);
Sunlight courtyard_light();

}  // namespace eifmap::simulation
