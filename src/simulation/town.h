// What streets are built of: houses, parked cars, trees. Each is drawn at random, and none is like
// another.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/random.h"
#include "simulation/scene.h"

namespace eifmap::simulation {

class Town {
 public:
  // The same seed always builds the same; `texels_per_m` of the facades and of the ground.
  Town(std::uint32_t seed, double facade_texels_per_m, double ground_texels_per_m);

  std::vector<Quad> take() { return std::move(quads_); }
  Random& random() { return random_; }

  // A paved rectangle under a cloudy sky.
  void ground_and_sky(double west, double east, double south, double north);

  // Its facade alone; `foot` is the middle of the lower edge.
  void house(const Eigen::Vector3d& foot, const Eigen::Vector3d& facing, double width);

  void parked_car(double x, double z, double yaw = 0);  // its length along z at yaw 0
  void tree(double x, double z);

 private:
  std::uint32_t next() { return seed_ + 17u * ++painted_; }

  Random random_;
  std::vector<Quad> quads_;
  std::uint32_t seed_, painted_ = 0;
  double facade_texels_per_m_, ground_texels_per_m_;
};

}  // namespace eifmap::simulation
