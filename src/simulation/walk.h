// A walk with a hand-held camera, around a closed loop or straight on.
#pragma once

#include <cstdint>

#include "geometry/rigid3.h"

namespace eifmap::simulation {

enum class Path : std::uint8_t {
  kEllipse,    // around the yard's middle
  kRectangle,  // straight, with a turn by 90 degrees in half a second at each corner
  kStraight,   // to the north from the origin, without end
};

struct Walk {
  Path path = Path::kEllipse;
  double half_east = 7.5, half_north = 5.2;  // m, of the ellipse
  double eye_height = 1.6;                   // m
  double speed = 2.15;                       // m/s along the path
  double inwards = 0.25;                     // rad, how far to the left of the way it looks
  double roll = 0;                           // rad, how far the camera is slowly rolled either way

  double lap_length() const;  // m, along a path that is closed

  // World x east, y down, z north; a loop starts in the south, heading east. `seconds` >= 0.
  Rigid3 world_from_camera(double seconds) const;
};

// Of the rectangle: when its first turn begins and ends.
struct TurnTimes {
  double begin = 0, end = 0;  // s
};
TurnTimes first_turn(const Walk& walk);

}  // namespace eifmap::simulation
