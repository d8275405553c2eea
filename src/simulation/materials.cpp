#include "simulation/materials.h"

#include <algorithm>

#include "simulation/value_noise.h"

namespace eifmap::simulation {
namespace {

int cell(float x) {
  return static_cast<int>(std::floor(x));
}
float fraction(float x) {
  return x - std::floor(x);
}

// 1 inside [low, high], with borders `soft` wide.
float band(float x, float low, float high, float soft) {
  return smooth_step(low - soft, low + soft, x) * (1 - smooth_step(high - soft, high + soft, x));
}

// What any old surface shows: dirt in all sizes, and stains and chips of 50, 20 and 7 cm with
// ragged borders.
float wear(float x, float y, std::uint32_t seed) {
  const float ragged = 0.045f * value_noise(17 * x, 17 * y, seed + 9);
  const float wx = x + ragged, wy = y - ragged;
  return 0.13f * fractal_noise(1.3f * x, 1.3f * y, 6, 0.62f, seed) +
         0.09f * spots(2.0f * wx, 2.0f * wy, 0.5f, seed + 11) +
         0.11f * spots(5.0f * wx + 0.37f, 5.0f * wy, 0.4f, seed + 12) +
         0.11f * spots(14.0f * x, 14.0f * y + 0.51f, 0.3f, seed + 13);
}

// Bricks or blocks in rows, every second one shifted by half: which one, and how far its border is.
struct Masonry {
  int column = 0, row = 0;
  float to_border = 0;  // m
};

Masonry masonry(float x, float y, float width, float height) {
  const int row = cell(y / height);
  const float shifted = x / width + (row % 2 != 0 ? 0.5f : 0.0f);
  const float dx = fraction(shifted), dy = fraction(y / height);
  return {cell(shifted), row,
          std::min(std::min(dx, 1 - dx) * width, std::min(dy, 1 - dy) * height)};
}

// Slabs around jittered centres (Voronoi cells).
struct Slab {
  std::uint32_t id = 0;
  float to_border = 0;  // in cells
};

Slab slab(float x, float y, std::uint32_t seed) {
  const int cx = cell(x), cy = cell(y);
  float first = 9, second = 9;
  Slab result;
  for (int j = cy - 1; j <= cy + 1; ++j) {
    for (int i = cx - 1; i <= cx + 1; ++i) {
      const float dx = static_cast<float>(i) + 0.15f + 0.7f * random_of_cell(i, j, seed) - x;
      const float dy = static_cast<float>(j) + 0.15f + 0.7f * random_of_cell(i, j, seed, 1) - y;
      const float d = dx * dx + dy * dy;
      if (d < first) {
        second = first;
        first = d;
        result.id = hash_cell(i, j, seed + 7);
      } else if (d < second) {
        second = d;
      }
    }
  }
  result.to_border = 0.5f * (std::sqrt(second) - std::sqrt(first));
  return result;
}

// A window pane: dark glass that mirrors a cloudy sky, sometimes a curtain.
float glass(float x, float y, int column, int storey, std::uint32_t seed) {
  const float mirror =
      0.14f + 0.10f * fractal_noise(2.2f * x + 9.0f * column, 1.7f * y, 4, 0.6f, seed);
  if (random_of_cell(column, storey, seed, 3) > 0.4f) return mirror;
  const float folds = 0.48f + 0.12f * value_noise(22 * x, 0.8f * y, seed + 5);
  const float edge = 0.2f + 0.3f * random_of_cell(column, storey, seed, 4) +
                     0.03f * value_noise(6 * y, 1.0f * column, seed + 6);
  return std::abs(x) > edge ? folds : mirror;
}

// (x, y) from the middle of a window of half size (w, h): frame, cross bars, sill, and shutters.
float window(float x, float y, float w, float h, int column, int storey, std::uint32_t seed,
             float outside) {
  constexpr float kSoft = 0.006f;
  if (random_of_cell(column, storey, seed, 2) < 0.35f) {  // shutters beside it
    const float beside = band(std::abs(x), w + 0.06f, w + 0.5f, kSoft) * band(y, -h, h, kSoft);
    const float slat = 0.26f + 0.16f * smooth_step(0.25f, 0.4f, fraction(y / 0.085f)) +
                       0.05f * value_noise(9 * x, 9 * y, seed + 9u * column);
    outside = mix(outside, slat, beside);
  }
  const float sill = band(x, -w - 0.12f, w + 0.12f, kSoft) * band(y, h, h + 0.09f, kSoft);
  outside = mix(outside, 0.82f, sill);
  const float frame = band(x, -w, w, kSoft) * band(y, -h, h, kSoft);
  const float pane = band(x, -w + 0.07f, w - 0.07f, kSoft) * band(y, -h + 0.07f, h - 0.07f, kSoft);
  const float bars = std::max(band(x, -0.025f, 0.025f, kSoft), band(y, -0.2f, -0.155f, kSoft));
  const float inner = mix(glass(x, y, column, storey, seed), 0.75f, bars);
  const float wood = 0.75f + 0.06f * value_noise(13 * x, 13 * y, seed);
  return mix(outside, mix(wood, inner, pane), frame);
}

float door(float x, float y, float w, float h, std::uint32_t seed, float outside) {
  constexpr float kSoft = 0.006f;
  const float surround = band(x, -w - 0.16f, w + 0.16f, kSoft) * band(y, -h - 0.16f, h, kSoft);
  const float leaf = band(x, -w, w, kSoft) * band(y, -h, h, kSoft);
  const float grain = 0.27f + 0.07f * fractal_noise(26 * x, 1.6f * y, 3, 0.6f, seed) -
                      0.15f * band(fraction(x / 0.2f), 0.0f, 0.07f, 0.03f);
  const float panel = band(std::abs(x), 0.1f, w - 0.1f, kSoft) *
                      band(fraction((y + h) / 0.75f), 0.15f, 0.85f, 0.02f);
  return mix(mix(outside, 0.7f, surround), grain - 0.07f * panel, leaf);
}

}  // namespace

Painter plaster(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    const float streaks = 0.06f * fractal_noise(5 * x, 0.45f * y, 3, 0.6f, seed + 20);
    const float bare =
        smooth_step(0.52f, 0.58f, fractal_noise(0.55f * x, 0.55f * y, 4, 0.5f, seed + 30));
    const Masonry under = masonry(x, y, 0.25f, 0.08f);
    const float brick = 0.36f + 0.2f * random_of_cell(under.column, under.row, seed + 31) +
                        0.2f * (1 - smooth_step(0.005f, 0.012f, under.to_border));
    return mix(albedo + streaks + wear(x, y, seed), brick + 0.5f * wear(x, y, seed), bare);
  };
}

Painter bricks(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    const Masonry m = masonry(x, y, 0.26f, 0.085f);
    const float tone = 0.36f * (random_of_cell(m.column, m.row, seed) - 0.5f) +
                       (random_of_cell(m.column, m.row, seed, 1) < 0.06f ? -0.16f : 0.0f);
    const float mortar = 1 - smooth_step(0.005f, 0.013f, m.to_border);
    return mix(albedo + tone, albedo + 0.22f, mortar) + 0.8f * wear(x, y, seed);
  };
}

Painter ashlar(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    const Masonry m = masonry(x, y, 0.62f, 0.31f);
    const float tone = 0.24f * (random_of_cell(m.column, m.row, seed) - 0.5f);
    const float joint = 1 - smooth_step(0.004f, 0.016f, m.to_border);
    const float worn = wear(x + 3.1f * m.column, y + 1.7f * m.row, seed);  // each block its own
    return albedo + tone + worn - 0.25f * joint;
  };
}

Painter paving(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    const Slab s = slab(2.1f * x, 2.1f * y, seed);
    const float tone = 0.26f * (static_cast<float>(s.id >> 8) / 16777216.0f - 0.5f);
    const float joint = 1 - smooth_step(0.02f, 0.05f, s.to_border);
    const float moss = 0.5f + 0.5f * value_noise(0.8f * x, 0.8f * y, seed + 40);
    return albedo + tone + 1.1f * wear(x, y, seed) - (0.16f + 0.16f * moss) * joint;
  };
}

Painter roof_tiles(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    const Masonry m = masonry(x, y, 0.24f, 0.3f);
    const float tone = 0.26f * (random_of_cell(m.column, m.row, seed) - 0.5f);
    const float along = fraction(y / 0.3f),
                across = std::abs(fraction(x / 0.24f + (m.row % 2) * 0.5f) - 0.5f);
    const float edge = smooth_step(0.86f - 0.3f * across * across, 0.97f, along);
    return albedo + tone - 0.28f * edge - 0.12f * smooth_step(0.4f, 0.5f, across) +
           0.8f * wear(x, y, seed);
  };
}

Painter hedge(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    const Slab leaf = slab(11 * x, 11 * y, seed);
    const Slab twig = slab(4 * x, 4 * y, seed + 3);
    const float tone = static_cast<float>(leaf.id >> 8) / 16777216.0f - 0.5f;
    const float shade = static_cast<float>(twig.id >> 8) / 16777216.0f - 0.5f;
    return albedo + 0.28f * tone + 0.16f * shade + 0.35f * std::min(leaf.to_border, 0.25f) - 0.05f +
           0.1f * fractal_noise(1.1f * x, 1.1f * y, 3, 0.6f, seed + 5);
  };
}

Painter planks(std::uint32_t seed, float albedo, float width, float height) {
  return [=](float x, float y) {
    constexpr float kFrame = 0.09f, kSoft = 0.006f;
    const float to_edge = std::min(std::min(x, width - x), std::min(y, height - y));
    const int board = cell(y / 0.16f);
    const float tone = 0.2f * (random_of_cell(board, 0, seed) - 0.5f);
    const float grain = 0.1f * fractal_noise(2.5f * x + 7.0f * board, 34 * y, 4, 0.6f, seed + 1);
    const float gap = band(fraction(y / 0.16f), 0.0f, 0.06f, 0.03f);
    const float frame = 1 - smooth_step(kFrame - kSoft, kFrame + kSoft, to_edge);
    const float rim = band(to_edge, kFrame, kFrame + 0.02f, kSoft);
    const float framed = albedo + 0.12f + 0.08f * fractal_noise(20 * x, 20 * y, 3, 0.6f, seed + 2);
    return mix(albedo + tone + grain - 0.22f * gap, framed, frame) - 0.25f * rim +
           0.7f * wear(x, y, seed);
  };
}

Painter water(std::uint32_t seed, float albedo) {
  return [=](float x, float y) {
    return albedo + 0.16f * fractal_noise(1.6f * x, 2.4f * y, 5, 0.6f, seed) +
           0.12f * spots(4 * x, 4 * y, 0.3f, seed + 1);
  };
}

Painter clouds(std::uint32_t seed, float size) {
  return [=](float x, float y) {
    const float dx = 2 * x / size - 1, dy = 2 * y / size - 1;
    const float haze = smooth_step(0.1f, 0.95f, std::sqrt(dx * dx + dy * dy));
    const float cover = fractal_noise(x / 90, y / 90, 6, 0.55f, seed);
    const float cloud = smooth_step(-0.15f, 0.75f, cover);
    const float sky = mix(0.60f, 0.95f, cloud);
    return mix(sky, 0.95f, haze);
  };
}

Painter facade(std::uint32_t seed, float width, float height, Painter ground) {
  return [=](float x, float y) {
    constexpr float kStorey = 3.1f, kWindow = 0.5f, kHalfHeight = 0.78f;
    const float bay = width / std::max(1.0f, std::round(width / 2.5f));
    const int column = cell(x / bay), storey = cell((height - y) / kStorey);
    const float from_middle = x - (static_cast<float>(column) + 0.5f) * bay;
    const float above_floor = height - y - kStorey * static_cast<float>(storey);
    float tone = ground(x, y);
    const float ledge = band(above_floor, 0.0f, 0.14f, 0.006f) * (storey > 0 ? 1.0f : 0.0f);
    tone = mix(tone, 0.74f + 0.05f * value_noise(8 * x, 8 * y, seed), ledge);
    tone -= 0.12f * band(above_floor, -0.05f, 0.0f, 0.006f) * (storey > 0 ? 1.0f : 0.0f);
    if (kStorey * static_cast<float>(storey + 1) > height + 0.3f) return tone;  // no room above
    const float kind = random_of_cell(column, storey, seed, 1);
    if (storey == 0 && kind < 0.25f)
      return door(from_middle, 1.15f - above_floor, 0.62f, 1.15f, seed + column, tone);
    if (kind > 0.9f) return tone;  // a blind bay
    return window(from_middle, 1.75f - above_floor, kWindow, kHalfHeight, column, storey, seed,
                  tone);
  };
}

Painter tiles(float side, Painter tile) {
  return [=](float x, float y) {
    const float dx = side * fraction(x / side), dy = side * fraction(y / side);
    const float to_border = std::min(std::min(dx, side - dx), std::min(dy, side - dy));
    const float joint = 1 - smooth_step(0.006f, 0.016f, to_border);
    return mix(tile(dx, dy), 0.3f, joint);
  };
}

Painter poster(std::uint32_t seed, float x0, float y0, Painter ground) {
  return [=](float x, float y) {
    constexpr float kWidth = 0.45f, kHeight = 0.62f, kSoft = 0.006f;
    const float dx = x - x0, dy = y - y0;
    const float paper = band(dx, -kWidth, kWidth, kSoft) * band(dy, -kHeight, kHeight, kSoft);
    if (paper == 0) return ground(x, y);
    const float line = (dy + kHeight) / 0.075f;
    const int row = cell(line);
    const float size = row >= 2 && row < 5 ? 0.12f : 0.035f;  // a heading, then print
    const int letter = cell((dx + kWidth) / size), line_of_text = row >= 2 && row < 5 ? 2 : row;
    const bool inked =
        random_of_cell(letter, line_of_text, seed) < 0.62f && row >= 2 &&
        std::abs(dx) < kWidth * (0.5f + 0.4f * random_of_cell(0, line_of_text, seed, 2));
    const float rows = row >= 2 && row < 5 ? 1.0f : band(fraction(line), 0.25f, 0.75f, 0.1f);
    const float print =
        inked ? rows * band(fraction((dx + kWidth) / size), 0.1f, 0.85f, 0.08f) : 0.0f;
    const float sheet = 0.88f - 0.7f * print + 0.05f * fractal_noise(4 * x, 4 * y, 3, 0.6f, seed);
    return mix(ground(x, y), sheet, paper);
  };
}

Quad cloudy_sky(std::uint32_t seed) {
  constexpr double kSize = 1600, kHeight = 140;
  Quad sky;
  sky.origin = {-kSize / 2, -kHeight, -kSize / 2};
  sky.u = {kSize, 0, 0};
  sky.v = {0, 0, kSize};
  sky.painter = clouds(seed, kSize);
  sky.texels_per_m = 0.64;
  sky.lit = false;
  return sky;
}

}  // namespace eifmap::simulation
