#include "simulation/texture.h"

#include <algorithm>
#include <cmath>

namespace eifmap::simulation {
namespace {

constexpr int kMaxProbes = 8;
// Trilinear filtering blurs more than a sensor's pixel does; half a level back is as sharp as can
// be without shimmer.
constexpr float kLevelBias = -0.5f;

int round_up(int value, int grain) {
  return (std::max(value, 1) + grain - 1) / grain * grain;
}

}  // namespace

Texture::Texture(int width, int height) {
  width = round_up(width, kGrain);
  height = round_up(height, kGrain);
  for (Level& level : levels_) {
    level.width = width;
    level.height = height;
    level.texels.resize(static_cast<std::size_t>(width) * height);
    width /= 2;
    height /= 2;
  }
}

void Texture::build_levels() {
  for (int k = 1; k < kLevels; ++k) {
    const Level& fine = levels_[k - 1];
    Level& coarse = levels_[k];
    for (int y = 0; y < coarse.height; ++y) {
      const std::uint8_t* above = &fine.texels[static_cast<std::size_t>(2 * y) * fine.width];
      const std::uint8_t* below = above + fine.width;
      std::uint8_t* out = &coarse.texels[static_cast<std::size_t>(y) * coarse.width];
      for (int x = 0; x < coarse.width; ++x)
        out[x] = static_cast<std::uint8_t>(
            (above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1] + 2) / 4);
    }
  }
}

float Texture::Level::bilinear(float s, float t) const {
  // The clamp keeps the four texels inside; kGrain makes every level at least one texel wide.
  s = std::clamp(s - 0.5f, 0.0f, static_cast<float>(width - 1));
  t = std::clamp(t - 0.5f, 0.0f, static_cast<float>(height - 1));
  const int x = static_cast<int>(s), y = static_cast<int>(t);
  const float u = s - static_cast<float>(x), v = t - static_cast<float>(y);
  const std::uint8_t* above = &texels[static_cast<std::size_t>(y) * width + x];
  const std::uint8_t* below = above + (y + 1 < height ? width : 0);
  const int right = x + 1 < width ? 1 : 0;
  const float top = above[0] + u * static_cast<float>(above[right] - above[0]);
  const float bottom = below[0] + u * static_cast<float>(below[right] - below[0]);
  return top + v * (bottom - top);
}

float Texture::trilinear(float s, float t, float level) const {
  level = std::clamp(level, 0.0f, static_cast<float>(kLevels - 1));
  const int k = static_cast<int>(level);
  const float share = level - static_cast<float>(k), scale = 1.0f / static_cast<float>(1 << k);
  const float fine = levels_[k].bilinear(s * scale, t * scale);
  if (share == 0) return fine;
  return fine + share * (levels_[k + 1].bilinear(s * scale * 0.5f, t * scale * 0.5f) - fine);
}

float Texture::sample(float s, float t, const Footprint& f) const {
  const float x2 = f.s_per_x * f.s_per_x + f.t_per_x * f.t_per_x;
  const float y2 = f.s_per_y * f.s_per_y + f.t_per_y * f.t_per_y;
  const bool along_x = x2 > y2;
  const float major = std::sqrt(along_x ? x2 : y2);
  const float area = std::abs(f.s_per_x * f.t_per_y - f.s_per_y * f.t_per_x);
  const float minor = std::max(area / std::max(major, 1e-6f), major / kMaxProbes);
  if (major <= 1) return levels_[0].bilinear(s, t);  // magnified: level 0, one probe
  const float level = std::log2(std::max(minor, 1e-6f)) + kLevelBias;
  const int probes = std::min(static_cast<int>(major / minor + 0.7f), kMaxProbes);
  const float ds = along_x ? f.s_per_x : f.s_per_y, dt = along_x ? f.t_per_x : f.t_per_y;
  float sum = 0;
  for (int i = 0; i < probes; ++i) {
    const float w = (static_cast<float>(i) + 0.5f) / static_cast<float>(probes) - 0.5f;
    sum += trilinear(s + w * ds, t + w * dt, level);
  }
  return sum / static_cast<float>(probes);
}

}  // namespace eifmap::simulation
