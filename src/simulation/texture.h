// Gray textures with mip levels and anisotropic sampling, so that a surface looks the same from
// near and far, head-on and grazing: what makes features repeatable.
#pragma once

#include <cstdint>
#include <vector>

namespace eifmap::simulation {

class Texture {
 public:
  // Sides are rounded up to multiples of kGrain texels so that every level halves exactly.
  static constexpr int kLevels = 7;
  static constexpr int kGrain = 1 << (kLevels - 1);

  Texture(int width, int height);

  int width() const { return levels_[0].width; }    // texels
  int height() const { return levels_[0].height; }  // texels
  std::uint8_t* row(int y) { return &levels_[0].texels[static_cast<std::size_t>(y) * width()]; }

  // To be called once level 0 is painted.
  void build_levels();

  // The footprint of a pixel: its two edges in texels.
  struct Footprint {
    float s_per_x, t_per_x, s_per_y, t_per_y;
  };

  // The mean gray (0-255) over the footprint around (s, t), texels; texel (0, 0) covers [0, 1)^2.
  float sample(float s, float t, const Footprint& footprint) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint8_t> texels;

    float bilinear(float s, float t) const;
  };

  float trilinear(float s, float t, float level) const;

  Level levels_[kLevels];
};

}  // namespace eifmap::simulation
