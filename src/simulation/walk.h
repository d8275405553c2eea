// A walk with a hand-held camera around a closed loop.
#pragma once

#include "geometry/rigid3.h"

namespace eifmap::simulation {

struct Walk {
  double half_east = 7.5, half_north = 5.2;  // m, of the ellipse
  double eye_height = 1.6;                   // m
  double speed = 2.15;                       // m/s along the ellipse

  double lap_length() const;  // m, along the ellipse

  // World x east, y down, z north; starts in the south, heading east. `seconds` >= 0.
  Rigid3 world_from_camera(double seconds) const;
};

}  // namespace eifmap::simulation
