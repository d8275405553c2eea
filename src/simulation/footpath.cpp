#include "simulation/footpath.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace eifmap::simulation {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;

}  // namespace

double RoundedRectangle::side_length(int side) const {
  return (side % 2 == 0 ? east - west : north - south) - 2 * radius;
}

double RoundedRectangle::lap_length() const {
  return 2 * (side_length(0) + side_length(1)) + 4 * kQuarter * radius;
}

// Sides and arcs in turn, each begun where the last one ended.
Footprint RoundedRectangle::at(double length) const {
  const double arc = radius * kQuarter;
  length = std::fmod(length, lap_length());
  Footprint at{{west + radius, 0, south}, {1, 0, 0}};
  for (int side = 0;; ++side) {
    const double straight = side_length(side);
    const Eigen::Vector3d left(-at.along.z(), 0, at.along.x());
    const double turned = std::clamp((length - straight) / radius, 0.0, kQuarter);
    at.centre += std::min(length, straight) * at.along +
                 radius * (std::sin(turned) * at.along + (1 - std::cos(turned)) * left);
    at.along = std::cos(turned) * at.along + std::sin(turned) * left;
    length -= straight + arc;
    if (length <= 0) return at;
  }
}

}  // namespace eifmap::simulation
