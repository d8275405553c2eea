// Random samples for RANSAC. Each sampler owns its state, so that a result depends on its seed
// alone and not on what ran before.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace eifmap {

class Sampler {
 public:
  explicit Sampler(int seed) : state_(static_cast<std::uint64_t>(seed)) {}

  // K different indices below n; n >= K.
  template <std::size_t K>
  std::array<std::size_t, K> draw(std::size_t n) {
    std::array<std::size_t, K> sample{};
    for (std::size_t k = 0; k < K; ++k) {
      bool repeated = true;
      while (repeated) {
        sample[k] = static_cast<std::size_t>(((next() >> 32) * n) >> 32);
        repeated = false;
        for (std::size_t l = 0; l < k; ++l) repeated = repeated || sample[l] == sample[k];
      }
    }
    return sample;
  }

 private:
  // SplitMix64 (S. Steele et al., OOPSLA 2014).
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

// Samples of `size` that must be drawn until one without an outlier was among them with probability
// `confidence`, at the share of inliers seen; at most `limit`.
inline int ransac_iterations_needed(double inlier_ratio, int size, double confidence, int limit) {
  const double good = std::pow(inlier_ratio, size);
  if (!(good > 0)) return limit;
  if (good >= 1) return 1;
  const double needed = std::ceil(std::log(1 - confidence) / std::log1p(-good));
  return needed < limit ? static_cast<int>(needed) : limit;
}

}  // namespace eifmap
