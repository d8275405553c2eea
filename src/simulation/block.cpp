#include "simulation/block.h"

#include <cmath>

#include "simulation/town.h"

namespace eifmap::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kHalfWidth = 4.5;             // m, of a street
constexpr double kEast = 13.5, kNorth = 10.5;  // m, half sizes of the way round
constexpr double kVerge = kHalfWidth - 1.15;   // m, from the way to what stands along it

// A side of the block: the way there leads to the left of who looks at it from its middle.
struct Side {
  Vector3d outwards, along;
  double to_way, half_length;  // m: from the block's middle; of the way
};

std::vector<Side> sides() {
  return {{{0, 0, -1}, {1, 0, 0}, kNorth, kEast},
          {{1, 0, 0}, {0, 0, 1}, kEast, kNorth},
          {{0, 0, 1}, {-1, 0, 0}, kNorth, kEast},
          {{-1, 0, 0}, {0, 0, -1}, kEast, kNorth}};
}

// The block itself: two houses a side, corner to corner.
void inner_houses(Town& town, const Side& side) {
  const double half = side.half_length - kHalfWidth;
  const double parting = town.random().uniform(-0.2, 0.2) * half;
  for (const auto& [from, to] : {std::pair(-half, parting), std::pair(parting, half)})
    town.house((side.to_way - kHalfWidth) * side.outwards + 0.5 * (from + to) * side.along,
               side.outwards, to - from);
}

// Across the street, and beyond the corner, where they meet those of the next side.
void outer_houses(Town& town, const Side& side) {
  const double end = side.half_length + kHalfWidth;
  double from = -end;
  while (from < end) {
    const double width = town.random().uniform(7, 12);
    town.house((side.to_way + kHalfWidth) * side.outwards + (from + 0.5 * width) * side.along,
               -side.outwards, width);
    from += width;
  }
}

// Not where the way turns.
void along_the_way(Town& town, const Side& side) {
  const double end = side.half_length - 1;
  for (double at = -end + town.random().uniform(0, 3); at < end;
       at += town.random().uniform(5, 8)) {
    const Vector3d place = (side.to_way + kVerge) * side.outwards + at * side.along;
    if (town.random().uniform() < 0.6)
      town.parked_car(place.x(), place.z(), std::atan2(side.along.x(), side.along.z()));
    else
      town.tree(place.x(), place.z());
  }
}

}  // namespace

std::vector<Quad> block(std::uint32_t seed) {
  Town town(seed + 40, 80, 60);
  const double east = kEast + kHalfWidth, north = kNorth + kHalfWidth;
  town.ground_and_sky(-east, east, -north, north);
  for (const Side& side : sides()) {
    inner_houses(town, side);
    outer_houses(town, side);
    along_the_way(town, side);
  }
  return town.take();
}

Motion drive_round_the_block(double speed) {
  constexpr double kRadius = 7, kEyeHeight = 1.5;  // m
  return driving_round({-kEast, kEast, -kNorth, kNorth, kRadius}, kEyeHeight, speed);
}

}  // namespace eifmap::simulation
