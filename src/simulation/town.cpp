#include "simulation/town.h"

#include "simulation/materials.h"

namespace eifmap::simulation {

using Eigen::Vector3d;

Town::Town(std::uint32_t seed, double facade_texels_per_m, double ground_texels_per_m)
    : random_(seed),
      seed_(1000 * seed + 300),
      facade_texels_per_m_(facade_texels_per_m),
      ground_texels_per_m_(ground_texels_per_m) {}

void Town::ground_and_sky(double west, double east, double south, double north) {
  Quad ground;
  ground.origin = {west, 0, north};
  ground.u = {east - west, 0, 0};
  ground.v = {0, 0, south - north};
  ground.painter = paving(next(), 0.42f);
  ground.texels_per_m = ground_texels_per_m_;
  quads_.push_back(ground);
  quads_.push_back(cloudy_sky(next()));
}

void Town::house(const Vector3d& foot, const Vector3d& facing, double width) {
  const double height = random_.uniform(5.5, 10);
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const Painter stone = random_.uniform() < 0.5 ? plaster(next(), 0.6f) : bricks(next(), 0.4f);
  quads_.push_back(wall(foot, facing, width, height, facade(next(), w, h, stone)));
  quads_.back().texels_per_m = facade_texels_per_m_;
}

void Town::parked_car(double x, double z, double yaw) {
  const Vector3d size(random_.uniform(1.6, 1.9), random_.uniform(1.3, 1.8),
                      random_.uniform(3.6, 4.8));
  const auto side = [&](int) { return plaster(next(), 0.35f); };
  add_box(quads_, {{x, 0, z}, yaw + random_.uniform(-0.04, 0.04), size, 60}, side);
}

void Town::tree(double x, double z) {
  add_pillar(quads_, {x, 0, z}, 0.18, 2.4, [&](int) { return planks(next(), 0.3f, 1, 3); });
  const double size = random_.uniform(1.6, 2.4);
  add_box(quads_, {{x, -2.3, z}, random_.uniform(0, 1.5), {size, size, size}, 60},
          [&](int) { return hedge(next(), 0.3f); });
}

}  // namespace eifmap::simulation
