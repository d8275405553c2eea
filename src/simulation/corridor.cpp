#include "simulation/corridor.h"

#include <cmath>
#include <numbers>

#include "simulation/materials.h"
#include "simulation/value_noise.h"

namespace eifmap::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kHalfWidth = 1.2, kHeight = 2.7;  // m
constexpr double kPeriod = 4.2;                    // m; seven tiles
constexpr double kSouth = -2 * kPeriod, kNorth = 13 * kPeriod;
constexpr double kTexels = 150;  // a metre: the walls are near

// The same again each period.
Painter repeated(Painter once) {
  return [once = std::move(once)](float x, float y) {
    constexpr auto period = static_cast<float>(kPeriod);
    return once(x - period * std::floor(x / period), y);
  };
}

// No sun comes here: a lamp each period, nearest in its middle.
Painter lamplit(Painter surface) {
  return [surface = std::move(surface)](float x, float y) {
    constexpr float kTurn = 2 * std::numbers::pi_v<float>;
    return surface(x, y) * (1.1f - 0.25f * std::cos(kTurn * x / static_cast<float>(kPeriod)));
  };
}

Painter framed(float left, float right, float top, float bottom, Painter inner, Painter ground) {
  return [=](float x, float y) {
    if (x < left || x > right || y < top || y > bottom) return ground(x, y);
    return inner(x - left, y - top);
  };
}

// A door, a board with print beside it, a darker base; each wall has its own.
Painter side_wall(std::uint32_t seed, float door_from, float board_at) {
  constexpr auto height = static_cast<float>(kHeight), period = static_cast<float>(kPeriod);
  constexpr float kDoorWidth = 0.95f, kDoorTop = height - 2.05f, kBase = 0.12f;
  const Painter plain = plaster(seed, 0.62f);
  const Painter based =
      framed(0, period, height - kBase, height, planks(seed + 1, 0.3f, period, kBase), plain);
  const Painter door = planks(seed + 2, 0.4f, kDoorWidth, 2.05f);
  return lamplit(repeated(framed(door_from, door_from + kDoorWidth, kDoorTop, height, door,
                                 poster(seed + 3, board_at, 1.15f, based))));
}

// Of the corridor's direction along x, seen from within.
Painter ceiling(std::uint32_t seed) {
  constexpr auto period = static_cast<float>(kPeriod);
  const Painter panels = tiles(0.6f, plaster(seed, 0.5f));
  const Painter lamp = [](float, float) { return 0.95f; };
  return lamplit(
      repeated(framed(0.5f * period - 0.6f, 0.5f * period + 0.6f, 1.05f, 1.35f, lamp, panels)));
}

// A floor or a ceiling, whose painter has x to the north.
Quad level(double height, bool looks_up, Painter painter) {
  Quad quad;
  const double west = looks_up ? kHalfWidth : -kHalfWidth;
  quad.origin = {-west, -height, kSouth};
  quad.u = {0, 0, kNorth - kSouth};
  quad.v = {2 * west, 0, 0};
  quad.painter = std::move(painter);
  return quad;
}

void box(std::vector<Quad>& quads, const Vector3d& foot, const Vector3d& size,
         const std::function<Painter(int)>& side) {
  add_box(quads, {foot, 0, size, kTexels}, side);
}

// What stands out of the walls, the same each period: a radiator on one side, a pilaster on both.
void things(std::vector<Quad>& quads, std::uint32_t seed) {
  for (double z = kSouth; z < kNorth; z += kPeriod) {
    box(quads, {kHalfWidth - 0.07, -0.15, z + 3.2}, {0.14, 0.6, 1.2}, [seed](int i) {
      return planks(seed + 1 + 7u * static_cast<std::uint32_t>(i), 0.7f, i % 2 == 0 ? 0.14f : 1.2f,
                    0.6f);
    });
    for (const double side : {-1.0, 1.0})
      box(quads, {side * (kHalfWidth - 0.06), 0, z}, {0.12, kHeight, 0.3},
          [seed](int i) { return ashlar(seed + 3u * static_cast<std::uint32_t>(i), 0.5f); });
  }
}

}  // namespace

std::vector<Quad> corridor(std::uint32_t seed) {
  const std::uint32_t s = 1000 * seed + 700;
  constexpr double kMiddle = 0.5 * (kSouth + kNorth), kLength = kNorth - kSouth;
  constexpr auto kWidth = static_cast<float>(2 * kHalfWidth);
  std::vector<Quad> quads = {
      level(0, true, lamplit(tiles(0.6f, plaster(s, 0.45f)))),
      level(kHeight, false, ceiling(s + 50)),
      wall({-kHalfWidth, 0, kMiddle}, {1, 0, 0}, kLength, kHeight, side_wall(s + 100, 0.7f, 2.8f)),
      wall({kHalfWidth, 0, kMiddle}, {-1, 0, 0}, kLength, kHeight, side_wall(s + 150, 2.4f, 1.6f)),
      wall({0, 0, kNorth}, {0, 0, -1}, kWidth, kHeight,
           poster(s + 200, 0.7f, 1.1f, bricks(s + 201, 0.45f))),
      wall({0, 0, kSouth}, {0, 0, 1}, kWidth, kHeight, plaster(s + 202, 0.55f))};
  for (Quad& quad : quads) quad.texels_per_m = kTexels;
  things(quads, s + 300);
  for (Quad& quad : quads) quad.lit = false;
  return quads;
}

Walk walk_down_the_corridor() {
  Walk walk;
  walk.path = Path::kStraight;
  walk.speed = 1.4;
  walk.inwards = 0.1;
  return walk;
}

}  // namespace eifmap::simulation
