// The world `block`: four streets, 9 m wide, round a block of houses of 18 m x 12 m; parked cars
// and trees along their outer sides.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/motion.h"
#include "simulation/scene.h"

namespace eifmap::simulation {

std::vector<Quad> block(std::uint32_t seed);

// In the middle of the streets, to the left at each corner; a lap is 84 m.
Motion drive_round_the_block(double speed);

}  // namespace eifmap::simulation
