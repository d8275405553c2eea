// Noise added to keypoints, to measure how much a result owes to luck.
#pragma once

#include <cstdint>
#include <random>

#include "frame.h"

namespace eifmap {

class Jitter {
 public:
  // `sigma_px` >= 0 on each axis; 0 changes nothing. Throws std::invalid_argument.
  Jitter(double sigma_px, std::uint64_t seed);

  // Moves every keypoint; none leaves the image.
  void apply(FeatureFrame& frame);

 private:
  double gaussian();

  double sigma_px_;
  std::mt19937_64 random_;  // fixed by the standard, unlike its distributions
};

}  // namespace eifmap
