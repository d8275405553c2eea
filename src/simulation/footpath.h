// Ways on the ground, by how far one has gone along them.
#pragma once

#include <Eigen/Core>

namespace eifmap::simulation {

// A place on a way.
struct Footprint {
  Eigen::Vector3d centre, along;  // on the ground; unit
};

// Round a rectangle whose corners are arcs, to the left; begins where the southern arc to the
// west ends, heading east.
struct RoundedRectangle {
  double west = 0, east = 0, south = 0, north = 0;  // m
  double radius = 0;                                // m, of the arcs

  double side_length(int side) const;  // m; of a straight part, by its number from the first
  double lap_length() const;           // m
  Footprint at(double length) const;   // `length` m (>= 0) along the way
};

}  // namespace eifmap::simulation
