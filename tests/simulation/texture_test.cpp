#include "simulation/texture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace eifmap::simulation {
namespace {

template <typename Paint>
Texture painted(int width, int height, Paint paint) {
  Texture texture(width, height);
  for (int y = 0; y < texture.height(); ++y)
    for (int x = 0; x < texture.width(); ++x)
      texture.row(y)[x] = static_cast<std::uint8_t>(paint(x, y));
  texture.build_levels();
  return texture;
}

TEST(Texture, SidesAreRoundedUpSoThatEveryLevelHalves) {
  const Texture texture(65, 1);
  EXPECT_EQ(texture.width(), 128);
  EXPECT_EQ(texture.height(), 64);
}

TEST(Texture, MagnifiedItInterpolatesBetweenTexelCentres) {
  const auto texture = painted(64, 64, [](int x, int y) { return 2 * x + y; });
  const Texture::Footprint tiny{0.01f, 0, 0, 0.01f};
  EXPECT_FLOAT_EQ(texture.sample(10.5f, 20.5f, tiny), 40);
  EXPECT_FLOAT_EQ(texture.sample(11.0f, 20.5f, tiny), 41);
  EXPECT_FLOAT_EQ(texture.sample(10.5f, 20.75f, tiny), 40.25f);
  EXPECT_FLOAT_EQ(texture.sample(-50, -50, tiny), 0);  // beyond the border: its nearest texel
}

TEST(Texture, ALinearRampKeepsItsValueAtEverySize) {
  const auto texture = painted(1024, 1024, [](int x, int) { return x / 5; });
  for (float size : {1.5f, 3.0f, 7.0f, 20.0f, 60.0f})
    EXPECT_NEAR(texture.sample(512, 512, {size, 0, 0, size}), 512 / 5.0, 1.0) << size;
}

TEST(Texture, AFinePatternFadesToItsMean) {
  const auto board = painted(512, 512, [](int x, int y) { return (x + y) % 2 * 255; });
  for (float at : {100.0f, 100.3f, 100.9f})
    EXPECT_NEAR(board.sample(at, 131.7f, {8, 0, 0, 8}), 127.5, 2);
}

// Seen at a grazing angle, stripes across the long way vanish, stripes along it stay.
TEST(Texture, AGrazingViewBlursOneWayOnly) {
  const Texture::Footprint grazing{1, 0, 0, 8};
  const auto along = painted(512, 512, [](int x, int) { return x / 2 % 2 * 255; });
  const auto across = painted(512, 512, [](int, int y) { return y / 2 % 2 * 255; });
  const auto contrast = [&grazing](const Texture& texture) {
    float low = 255, high = 0;
    for (int i = 0; i < 64; ++i) {
      const float g = texture.sample(200 + 0.25f * static_cast<float>(i),
                                     200 + 0.25f * static_cast<float>(i), grazing);
      low = std::min(low, g), high = std::max(high, g);
    }
    return high - low;
  };
  EXPECT_GT(contrast(along), 150);
  EXPECT_LT(contrast(across), 20);
}

}  // namespace
}  // namespace eifmap::simulation
