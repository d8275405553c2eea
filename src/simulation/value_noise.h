// Reproducible randomness for painting: pure functions of position and seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace eifmap::simulation {

// A well-mixed 32-bit hash of a cell and a seed.
inline std::uint32_t hash_cell(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = seed * 0x9E3779B9u + static_cast<std::uint32_t>(x) * 0x85EBCA6Bu +
                    static_cast<std::uint32_t>(y) * 0xC2B2AE35u;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  return h ^ (h >> 13);
}

// [0, 1), one per cell; `k` tells independent draws of the same cell apart.
inline float random_of_cell(std::int32_t x, std::int32_t y, std::uint32_t seed,
                            std::uint32_t k = 0) {
  return static_cast<float>(hash_cell(x, y, seed + 0x68E31DA4u * k) >> 8) * (1.0f / 16777216.0f);
}

// The largest whole number that is not above x; std::floor is a call where SSE 4.1 may be missing.
inline std::int32_t floor_of(float x) {
  const auto i = static_cast<std::int32_t>(x);
  return i - (x < static_cast<float>(i) ? 1 : 0);
}

inline float smooth(float t) {
  return t * t * (3 - 2 * t);
}

// 0 below `low`, 1 above `high`, smooth between.
inline float smooth_step(float low, float high, float x) {
  const float t = (x - low) / (high - low);
  return t <= 0 ? 0.0f : t >= 1 ? 1.0f : smooth(t);
}

inline float mix(float a, float b, float t) {
  return a + (b - a) * t;
}

// Random values in [-1, 1) that noise takes its lattice from: one row, wrapped around, read with
// another start for every seed and row of the lattice. Four times as fast as hashing each corner.
inline constexpr std::uint32_t kLatticeSize = 1u << 16;
inline const std::vector<float> kLattice = [] {
  std::vector<float> values(kLatticeSize);
  for (std::uint32_t i = 0; i < kLatticeSize; ++i)
    values[i] = 2 * random_of_cell(static_cast<std::int32_t>(i), 0, 77) - 1;
  return values;
}();

// Smooth noise in [-1, 1] with one feature per unit of x and y.
inline float value_noise(float x, float y, std::uint32_t seed) {
  constexpr std::uint32_t kRow = 10007;
  const std::int32_t ix = floor_of(x), iy = floor_of(y);
  const std::uint32_t start =
      static_cast<std::uint32_t>(ix) + kRow * static_cast<std::uint32_t>(iy) + seed * 0x9E3779B9u;
  const auto at = [start](std::uint32_t offset) {
    return kLattice[(start + offset) % kLatticeSize];
  };
  const float u = smooth(x - static_cast<float>(ix)), v = smooth(y - static_cast<float>(iy));
  return mix(mix(at(0), at(1), u), mix(at(kRow), at(kRow + 1), u), v);
}

// Octaves of value noise: the k-th has 2^k times the frequency and `gain`^k the amplitude.
inline float fractal_noise(float x, float y, int octaves, float gain, std::uint32_t seed) {
  float sum = 0, amplitude = 1;
  for (int k = 0; k < octaves; ++k, amplitude *= gain, x *= 2, y *= 2)
    sum += amplitude * value_noise(x, y, seed + 101u * k);
  return sum;
}

// A round spot somewhere in each unit cell, never cut by its border: in [-1, 1], 0 between spots.
// `share` of the cells have one; light and dark alike.
inline float spots(float x, float y, float share, std::uint32_t seed) {
  const std::int32_t ix = floor_of(x), iy = floor_of(y);
  if (random_of_cell(ix, iy, seed) >= share) return 0;
  const float radius = 0.12f + 0.28f * random_of_cell(ix, iy, seed, 1);
  const float cx = radius + (1 - 2 * radius) * random_of_cell(ix, iy, seed, 2);
  const float cy = radius + (1 - 2 * radius) * random_of_cell(ix, iy, seed, 3);
  const float dx = x - static_cast<float>(ix) - cx;
  const float dy =
      (y - static_cast<float>(iy) - cy) * (0.8f + 0.6f * random_of_cell(ix, iy, seed, 4));
  const float level = 1 - smooth_step(0.55f * radius, radius, std::sqrt(dx * dx + dy * dy));
  return random_of_cell(ix, iy, seed, 5) < 0.5f ? -level : level;
}

}  // namespace eifmap::simulation
