// Ways of a simulated camera: simple ones, and what may happen to any of them on the way.
#pragma once

#include <functional>

#include "geometry/rigid3.h"
#include "simulation/footpath.h"
#include "simulation/walk.h"

namespace eifmap::simulation {

// world_from_camera after so many seconds (>= 0) on the way.
using Motion = std::function<Rigid3(double seconds)>;

Motion walking(const Walk& walk);
Motion standing(const Rigid3& place);

// Straight on along the optical axis, as a car: swaying and nodding a little. `speed` in m/s.
Motion driving(const Rigid3& start, double speed);

// The same round a block, at a height above the ground and always at that speed.
Motion driving_round(const RoundedRectangle& way, double height, double speed);

// To the right, turning slightly to either side.
Motion moving_sideways(const Rigid3& start, double speed);

// Only turning, by `angle` (rad) about the vertical and back, once in `period` seconds.
Motion panning(const Rigid3& place, double angle, double period);

// From `from` on stands still for `length` s, then goes on.
Motion with_pause(Motion motion, double from, double length);

// The same, and turns on the spot by `angle` (rad) and back during the pause.
Motion with_look_around(Motion motion, double from, double length, double angle);

// Carried away: from `from` on it stands for `length` s where it is after `to` s of its way, then
// goes on from there.
Motion with_carrying(Motion motion, double from, double length, double to);

}  // namespace eifmap::simulation
