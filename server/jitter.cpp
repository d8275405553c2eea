#include "server/jitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace eifmap {

Jitter::Jitter(double sigma_px, std::uint64_t seed) : sigma_px_(sigma_px), random_(seed) {
  if (!(sigma_px >= 0) || !std::isfinite(sigma_px))
    throw std::invalid_argument("jitter_px: must be a finite number, at least 0");
}

// Box and Muller, its second number thrown away for simplicity.
double Jitter::gaussian() {
  const auto uniform = [this] {  // in (0, 1]
    return (static_cast<double>(random_() >> 11) + 1) * 0x1p-53;
  };
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

void Jitter::apply(FeatureFrame& frame) {
  if (sigma_px_ == 0) return;
  const auto move = [this](float x, int side) {
    const double moved = x + sigma_px_ * gaussian();
    return static_cast<float>(std::clamp(moved, -0.5, side - 0.5));
  };
  for (Keypoint& keypoint : frame.keypoints) {
    keypoint.u = move(keypoint.u, frame.width);
    keypoint.v = move(keypoint.v, frame.height);
  }
}

}  // namespace eifmap
