// Images that are nothing but descriptors.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "frame.h"
#include "support/random.h"

namespace eifmap::test {

inline std::vector<std::int8_t> random_descriptors(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<std::int8_t> descriptors;
  for (int i = 0; i < count; ++i) {
    Eigen::Matrix<double, kDescriptorSize, 1> descriptor;
    for (double& x : descriptor) x = random.uniform(-1, 1);
    descriptor *= 254 / descriptor.norm();
    for (const double x : descriptor)
      descriptors.push_back(static_cast<std::int8_t>(std::clamp(std::lround(x), -127l, 127l)));
  }
  return descriptors;
}

// One of each sign in turn.
inline FeatureFrame random_frame(std::uint64_t seed, int features = 200) {
  FeatureFrame frame;
  frame.descriptors = random_descriptors(seed, features);
  frame.keypoints.resize(static_cast<std::size_t>(features));
  for (int i = 0; i < features; ++i)
    frame.keypoints[i].laplacian_sign = static_cast<std::int8_t>(i % 2 == 0 ? 1 : -1);
  return frame;
}

// Half of it is gone, half of that looks a little different.
inline FeatureFrame seen_again(const FeatureFrame& frame, std::uint64_t seed) {
  Random random(seed);
  FeatureFrame again;
  for (std::size_t i = 0; i < frame.keypoints.size(); ++i) {
    if (random.uniform() < 0.5) continue;
    again.keypoints.push_back(frame.keypoints[i]);
    const int noise = random.uniform() < 0.5 ? 8 : 0;
    for (int e = 0; e < kDescriptorSize; ++e) {
      const int byte = frame.descriptors[i * kDescriptorSize + e] +
                       static_cast<int>(std::lround(noise * random.normal()));
      again.descriptors.push_back(static_cast<std::int8_t>(std::clamp(byte, -127, 127)));
    }
  }
  return again;
}

}  // namespace eifmap::test
