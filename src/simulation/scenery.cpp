#include "simulation/scenery.h"

#include "simulation/block.h"
#include "simulation/corridor.h"
#include "simulation/courtyard.h"
#include "simulation/materials.h"
#include "simulation/street.h"
#include "simulation/walk.h"

namespace eifmap::simulation {
namespace {

using Eigen::Vector3d;

Scenery in_courtyard(std::uint32_t seed) {
  const Rigid3 place = Walk().world_from_camera(0);
  return {courtyard(seed), courtyard_light(), place, place};
}

Quad floor_of(double half_east, double half_north, Painter painter, double texels_per_m) {
  Quad quad;
  quad.origin = {-half_east, 0, half_north};
  quad.u = {2 * half_east, 0, 0};
  quad.v = {0, 0, -2 * half_north};
  quad.painter = std::move(painter);
  quad.texels_per_m = texels_per_m;
  return quad;
}

// A walk around the courtyard fits into it.
Scenery tiled_room(std::uint32_t seed) {
  constexpr double kEast = 12, kNorth = 9, kHeight = 8;
  constexpr float kSide = 0.75f;
  const Painter painter = tiles(kSide, plaster(1000 * seed, 0.55f));
  Scenery scenery = in_courtyard(seed);
  scenery.quads = {floor_of(kEast, kNorth, painter, 100),
                   wall({0, 0, kNorth}, {0, 0, -1}, 2 * kEast, kHeight, painter),
                   wall({0, 0, -kNorth}, {0, 0, 1}, 2 * kEast, kHeight, painter),
                   wall({kEast, 0, 0}, {-1, 0, 0}, 2 * kNorth, kHeight, painter),
                   wall({-kEast, 0, 0}, {1, 0, 0}, 2 * kNorth, kHeight, painter)};
  return scenery;
}

// As high as the view from 5 m at any turn that a camera makes here.
Scenery one_wall(std::uint32_t seed) {
  constexpr double kDistance = 5, kWidth = 36, kHeight = 14;
  const std::uint32_t s = 1000 * seed;
  const Painter ground = poster(s + 1, 18, 7, poster(s + 2, 20.5f, 6.5f, plaster(s + 3, 0.58f)));
  Scenery scenery;
  scenery.quads = {wall({8, kHeight / 2, kDistance}, {0, 0, -1}, kWidth, kHeight, ground)};
  return scenery;
}

Scenery in_street(std::uint32_t seed) {
  const Rigid3 facing_east(so3_exp({0, M_PI / 2, 0}), {-6.5, -1.6, 60});
  return {street(seed), courtyard_light(), {so3_exp({0, 0, 0}), {-1.6, -1.5, 0}}, facing_east};
}

Scenery round_a_block(std::uint32_t seed) {
  const Rigid3 place = drive_round_the_block(1)(0);
  return {block(seed), courtyard_light(), place, place};
}

Scenery in_corridor(std::uint32_t seed) {
  const Rigid3 place = walk_down_the_corridor().world_from_camera(0);
  return {corridor(seed), courtyard_light(), place, place};
}

}  // namespace

Scenery make_scenery(const std::string& world, std::uint32_t seed) {
  if (world == "courtyard") return in_courtyard(seed);
  if (world == "tiles") return tiled_room(seed);
  if (world == "wall") return one_wall(seed);
  if (world == "street") return in_street(seed);
  if (world == "block") return round_a_block(seed);
  if (world == "corridor") return in_corridor(seed);
  return {};
}

std::vector<Quad> bus(std::uint32_t seed) {
  const std::uint32_t s = 1000 * seed + 500;
  std::vector<Quad> quads;
  add_box(quads, {{0, -0.3, 0}, 0, {7, 2.8, 2.4}, 100}, [s](int i) {
    const std::uint32_t side = s + 20u * static_cast<std::uint32_t>(i);
    return facade(side, 7, 2.8f, poster(side + 1, 1.6f, 1.4f, plaster(side + 2, 0.5f)));
  });
  return quads;
}

Motion bus_ride(const Rigid3& view, double from, double length, bool to_the_left) {
  constexpr double kAhead = 7, kHalfWay = 9;  // m; half the view and half the bus
  Eigen::Vector3d middle = view * Eigen::Vector3d(0, 0, kAhead);
  middle.y() = 0;
  const Eigen::Vector3d right = view.rotation * Eigen::Vector3d::UnitX();
  return [=](double t) {
    const double part = 2 * (t - from) / length - 1;
    return Rigid3(view.rotation, middle + (to_the_left ? -part : part) * kHalfWay * right);
  };
}

}  // namespace eifmap::simulation
