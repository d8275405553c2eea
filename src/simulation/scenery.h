// The worlds by their names, and where cameras begin in them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/rigid3.h"
#include "simulation/motion.h"
#include "simulation/scene.h"

namespace eifmap::simulation {

struct Scenery {
  std::vector<Quad> quads;
  Sunlight light;
  Rigid3 along;   // of a camera that drives ahead
  Rigid3 across;  // of one that stands, pans or moves sideways
};

// `courtyard` (courtyard.h); `tiles`: a room as large as it, all of it the same tile again and
// again; `wall`: one painted wall that fills the view; `street`: 200 m between houses, parked cars
// and trees along it; `block` (block.h); `corridor` (corridor.h). Of another name it is empty.
Scenery make_scenery(const std::string& world, std::uint32_t seed);

// A box of 7 m that stands on the origin, its length along x.
std::vector<Quad> bus(std::uint32_t seed);

// world_from_bus: past a camera that stands at `view`, 7 m before it and level, in its view from
// `from` for `length` s; to the camera's left, or to its right.
Motion bus_ride(const Rigid3& view, double from, double length, bool to_the_left);

}  // namespace eifmap::simulation
