#include "simulation/street.h"

#include "simulation/materials.h"
#include "simulation/random.h"

namespace eifmap::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kHalfWidth = 8, kSouth = -20, kNorth = 200;  // m

class Builder {
 public:
  explicit Builder(std::uint32_t seed) : random_(seed), seed_(1000 * seed + 300) {}

  std::vector<Quad> take() { return std::move(quads_); }

  void ground_and_sky() {
    Quad ground;
    ground.origin = {-kHalfWidth - 1.3, 0, kNorth};
    ground.u = {2 * kHalfWidth + 2.6, 0, 0};  // under the houses that stand back
    ground.v = {0, 0, kSouth - kNorth};
    ground.painter = paving(next(), 0.42f);
    ground.texels_per_m = 40;
    quads_.push_back(ground);
    quads_.push_back(cloudy_sky(next()));
  }

  void house(const Vector3d& foot, const Vector3d& facing, double width) {
    const double height = random_.uniform(5.5, 10);
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    const Painter stone = random_.uniform() < 0.5 ? plaster(next(), 0.6f) : bricks(next(), 0.4f);
    quads_.push_back(wall(foot, facing, width, height, facade(next(), w, h, stone)));
    quads_.back().texels_per_m = 50;
  }

  void rows_of_houses() {
    for (const double side : {-1.0, 1.0}) {
      double from = kSouth;
      while (from < kNorth) {
        const double width = random_.uniform(9, 18), set_back = random_.uniform(0, 1.2);
        house({side * (kHalfWidth + set_back), 0, from + width / 2}, {-side, 0, 0}, width);
        from += width;
      }
    }
    house({0, 0, kNorth}, {0, 0, -1}, 2 * kHalfWidth + 3);
  }

  void parked_car(double x, double z) {
    const Vector3d size(random_.uniform(1.6, 1.9), random_.uniform(1.3, 1.8),
                        random_.uniform(3.6, 4.8));
    const auto side = [&](int) { return plaster(next(), 0.35f); };
    add_box(quads_, {{x, 0, z}, random_.uniform(-0.04, 0.04), size, 60}, side);
  }

  void tree(double x, double z) {
    add_pillar(quads_, {x, 0, z}, 0.18, 2.4, [&](int) { return planks(next(), 0.3f, 1, 3); });
    const double size = random_.uniform(1.6, 2.4);
    add_box(quads_, {{x, -2.3, z}, random_.uniform(0, 1.5), {size, size, size}, 60},
            [&](int) { return hedge(next(), 0.3f); });
  }

  void along_the_way() {
    for (const double side : {-1.0, 1.0})
      for (double z = kSouth + 5; z < kNorth - 5; z += random_.uniform(5.5, 13)) {
        // Nothing stands in front of who looks across from the western side.
        if (side < 0 && z > 40 && z < 68) continue;
        if (random_.uniform() < 0.6)
          parked_car(side * 5.4, z);
        else
          tree(side * 6.4, z);
      }
  }

 private:
  std::uint32_t next() { return seed_ + 17u * ++painted_; }

  Random random_;
  std::vector<Quad> quads_;
  std::uint32_t seed_, painted_ = 0;
};

}  // namespace

std::vector<Quad> street(std::uint32_t seed) {
  Builder b(seed);
  b.ground_and_sky();
  b.rows_of_houses();
  b.along_the_way();
  return b.take();
}

}  // namespace eifmap::simulation
