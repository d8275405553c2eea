#include "simulation/courtyard.h"

#include <cmath>

#include "simulation/materials.h"
#include "simulation/value_noise.h"

namespace eifmap::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kEast = 12, kNorth = 9;  // m, half sizes of the yard

class Builder {
 public:
  explicit Builder(std::uint32_t seed) : seed_(1000 * seed) {}

  std::vector<Quad> take() { return std::move(quads_); }

  void ground_and_sky() {
    Quad ground;
    ground.origin = {-kEast, 0, kNorth};
    ground.u = {2 * kEast, 0, 0};
    ground.v = {0, 0, -2 * kNorth};
    ground.painter = paving(next(), 0.46f);
    quads_.push_back(ground);
    quads_.push_back(cloudy_sky(next()));
  }

  // A wing whose facade looks into the yard, with its roof rising behind it.
  void wing(const Vector3d& foot, const Vector3d& facing, double width, double height,
            Painter front, double slope) {
    quads_.push_back(wall(foot, facing, width, height, std::move(front)));
    constexpr double kOverhang = 0.45, kDepth = 5;
    const Quad& face = quads_.back();
    const Vector3d right = face.u.normalized();
    const Vector3d down = (facing + slope * Vector3d(0, 1, 0)).normalized();  // along the roof
    Quad roof;
    roof.u = (width + 1) * right;
    roof.v = kDepth * down;
    roof.origin = face.origin - 0.5 * right + kOverhang * down - roof.v;
    roof.painter = roof_tiles(next(), 0.34f);
    roof.texels_per_m = 80;
    quads_.push_back(roof);
    Quad soffit = wall(foot - Vector3d(0, height - 0.05, 0) + 0.06 * facing, facing, width, 0.22,
                       planks(next(), 0.62f, static_cast<float>(width), 0.22f));
    quads_.push_back(soffit);
  }

  void box(const Vector3d& foot, double yaw_deg, const Vector3d& size,
           const std::function<Painter(int)>& side, double texels_per_m = 100) {
    add_box(quads_, {foot, yaw_deg * M_PI / 180, size, texels_per_m}, side);
  }

  void crate(double x, double z, double yaw_deg, double size, double base = 0) {
    const auto s = static_cast<float>(size);
    const auto tone = 0.36f + 0.22f * random_of_cell(static_cast<int>(quads_.size()), 0, seed_);
    box(
        {x, -base, z}, yaw_deg, {size, size, size}, [&](int) { return planks(next(), tone, s, s); },
        160);
  }

  void column(double x, double z) {
    box({x, 0, z}, 15, {0.55, 0.5, 0.55}, [&](int) { return ashlar(next(), 0.55f); });
    add_pillar(quads_, {x, -0.5, z}, 0.16, 1.5, [&](int) { return ashlar(next(), 0.62f); });
    box({x, -2.0, z}, 40, {0.44, 0.44, 0.44}, [&](int) { return plaster(next(), 0.64f); });
  }

  void hedge_box(double x, double z, double yaw_deg, const Vector3d& size) {
    box({x, 0, z}, yaw_deg, size, [&](int) { return hedge(next(), 0.27f); });
  }

  void bench(double x, double z, double yaw_deg) {
    const double yaw = yaw_deg * M_PI / 180;
    const Vector3d along(std::cos(yaw), 0, std::sin(yaw));
    for (double end : {-0.7, 0.7})
      box(Vector3d(x, 0, z) + end * along, yaw_deg, {0.16, 0.4, 0.42},
          [&](int) { return ashlar(next(), 0.5f); });
    box({x, -0.4, z}, yaw_deg, {1.9, 0.09, 0.5},
        [&](int) { return planks(next(), 0.5f, 1.9f, 0.5f); });
  }

  void chimney(double x, double base, double z) {
    box(
        {x, -base, z}, 0, {0.7, 2.2, 0.6}, [&](int) { return bricks(next(), 0.4f); }, 80);
  }

  // A roof on pillars along the west wing.
  void portico() {
    constexpr double kFront = -9.9;
    for (int i = 0; i < 7; ++i) {
      const Vector3d foot(kFront, 0, -7.2 + 2.4 * i);
      add_pillar(quads_, foot, 0.2, 3.1, [&](int) { return ashlar(next(), 0.6f); });
      box(foot, 0, {0.62, 0.35, 0.62}, [&](int) { return ashlar(next(), 0.5f); });
      box(foot - Vector3d(0, 2.85, 0), 0, {0.6, 0.25, 0.6},
          [&](int) { return plaster(next(), 0.66f); });
    }
    box({-11, -3.1, 0}, 0, {2.6, 0.5, 17},
        [&](int i) { return i == 4 ? roof_tiles(next(), 0.34f) : ashlar(next(), 0.58f); });
  }

  void fountain() {
    box({0, 0, 0}, 0, {3.6, 0.22, 3.6}, [&](int) { return ashlar(next(), 0.56f); });
    add_pillar(quads_, {0, -0.2, 0}, 1.25, 0.55, [&](int) { return ashlar(next(), 0.62f); });
    box({0, -0.2, 0}, 22.5, {1.75, 0.54, 1.75}, [&](int) { return water(next(), 0.42f); });
    add_pillar(quads_, {0, -0.6, 0}, 0.24, 1.9, [&](int) { return ashlar(next(), 0.64f); });
    box({0, -2.5, 0}, 30, {0.9, 0.18, 0.9}, [&](int) { return plaster(next(), 0.7f); });
    box({0, -2.68, 0}, 10, {0.42, 0.6, 0.42}, [&](int) { return plaster(next(), 0.62f); });
  }

  std::uint32_t next() { return seed_ + 17u * ++painted_; }

 private:
  std::vector<Quad> quads_;
  std::uint32_t seed_, painted_ = 0;
};

void wings(Builder& b) {
  b.wing(
      {0, 0, kNorth}, {0, 0, -1}, 2 * kEast, 6.6,
      facade(b.next(), 24, 6.6f,
             poster(b.next(), 7.2f, 4.9f, poster(b.next(), 19.2f, 4.8f, plaster(b.next(), 0.62f)))),
      0.75);
  b.wing({0, 0, -kNorth}, {0, 0, 1}, 2 * kEast, 4.1,
         facade(b.next(), 24, 4.1f, poster(b.next(), 12.0f, 2.2f, bricks(b.next(), 0.42f))), 0.6);
  b.wing({kEast, 0, 0}, {-1, 0, 0}, 2 * kNorth, 7.4,
         facade(b.next(), 18, 7.4f, poster(b.next(), 2.57f, 5.6f, bricks(b.next(), 0.36f))), 0.85);
  b.wing({-kEast, 0, 0}, {1, 0, 0}, 2 * kNorth, 5.4,
         facade(b.next(), 18, 5.4f, plaster(b.next(), 0.56f)), 0.7);
}

void things_along_the_way(Builder& b) {
  b.crate(9.6, 6.9, 20, 1.1);
  b.crate(10.9, 6.2, -8, 0.9);
  b.crate(9.7, 7.0, 41, 0.7, 1.1);
  b.crate(10.4, -6.6, 35, 1.0);
  b.crate(9.2, -7.4, 5, 0.75);
  b.crate(5.4, -1.3, 52, 0.7);
  b.crate(5.9, -0.7, 10, 0.5);
  b.crate(-1.2, 3.4, 28, 0.8);
  b.crate(-5.6, -0.6, 3, 0.65);
  b.column(1.6, -3.4);
  b.column(4.6, 1.9);
  b.column(1.2, 3.9);
  b.column(-4.4, 2.2);
  b.column(-3.6, -2.7);
  b.hedge_box(-1.5, 8.2, 0, {3.8, 0.9, 0.8});
  b.hedge_box(5.6, 8.2, 0, {2.6, 1.2, 0.8});
  b.hedge_box(0.5, -8.2, 0, {3.2, 0.8, 0.8});
  b.hedge_box(-6.4, -8.1, 0, {2.2, 1.3, 0.9});
  b.hedge_box(11.2, 0.8, 0, {0.8, 1.0, 3.4});
  b.hedge_box(3.4, -2.7, 30, {1.3, 0.7, 0.7});
  b.bench(2.3, -7.9, 0);
  b.bench(-6.2, 8.0, 0);
  b.bench(-0.6, -3.2, 0);
}

}  // namespace

std::vector<Quad> courtyard(std::uint32_t seed) {
  Builder b(seed);
  b.ground_and_sky();
  wings(b);
  b.chimney(-5, 8.2, 11.3);
  b.chimney(4, 8.2, 11.5);
  b.chimney(-3, 5.2, -11.2);
  b.chimney(7.5, 5.2, -11.0);
  b.chimney(14.2, 9.4, -4);
  b.chimney(-14, 6.6, 3);
  b.portico();
  b.fountain();
  things_along_the_way(b);
  return b.take();
}

Sunlight courtyard_light() {
  return {};
}

}  // namespace eifmap::simulation
