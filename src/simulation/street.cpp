#include "simulation/street.h"

#include "simulation/town.h"

namespace eifmap::simulation {
namespace {

constexpr double kHalfWidth = 8, kSouth = -20, kNorth = 200;  // m

void rows_of_houses(Town& town) {
  for (const double side : {-1.0, 1.0}) {
    double from = kSouth;
    while (from < kNorth) {
      const double width = town.random().uniform(9, 18), set_back = town.random().uniform(0, 1.2);
      town.house({side * (kHalfWidth + set_back), 0, from + width / 2}, {-side, 0, 0}, width);
      from += width;
    }
  }
  town.house({0, 0, kNorth}, {0, 0, -1}, 2 * kHalfWidth + 3);
}

void along_the_way(Town& town) {
  for (const double side : {-1.0, 1.0})
    for (double z = kSouth + 5; z < kNorth - 5; z += town.random().uniform(5.5, 13)) {
      // Nothing stands in front of who looks across from the western side.
      if (side < 0 && z > 40 && z < 68) continue;
      if (town.random().uniform() < 0.6)
        town.parked_car(side * 5.4, z);
      else
        town.tree(side * 6.4, z);
    }
}

}  // namespace

std::vector<Quad> street(std::uint32_t seed) {
  Town town(seed, 50, 40);
  // Under the houses that stand back, too.
  town.ground_and_sky(-kHalfWidth - 1.3, kHalfWidth + 1.3, kSouth, kNorth);
  rows_of_houses(town);
  along_the_way(town);
  return town.take();
}

}  // namespace eifmap::simulation
