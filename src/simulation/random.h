// Random numbers that are the same on every machine, since the distributions of <random> are not.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

namespace eifmap::simulation {

// SplitMix64 (S. Steele et al., OOPSLA 2014).
class Random {
 public:
  // The seed is mixed first: streams of neighbouring seeds must not be one another's continuations.
  explicit Random(std::uint64_t seed) : state_(seed) { state_ = bits() ^ (seed << 32); }

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  // [0, 1)
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  // Standard normal (Box-Muller).
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * M_PI * uniform());
  }
  template <int N>
  Eigen::Matrix<double, N, 1> normal_vector() {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = normal();
    return v;
  }

  Eigen::Vector3d unit_vector() { return normal_vector<3>().normalized(); }
  Eigen::Quaterniond rotation() { return Eigen::Quaterniond(normal_vector<4>().normalized()); }

 private:
  std::uint64_t state_;
};

}  // namespace eifmap::simulation
