// Procedural materials, each with structure from decimetres down to a texel: what a feature
// detector finds at any distance. The same seed always paints the same surface; no two seeds paint
// alike.
#pragma once

#include <cstdint>

#include "simulation/scene.h"

namespace eifmap::simulation {

Painter plaster(std::uint32_t seed, float albedo);     // stains, patches, streaks of rain
Painter bricks(std::uint32_t seed, float albedo);      // each its own tone, light mortar
Painter ashlar(std::uint32_t seed, float albedo);      // blocks of cut stone
Painter paving(std::uint32_t seed, float albedo);      // irregular slabs with joints
Painter roof_tiles(std::uint32_t seed, float albedo);  // rows of tiles
Painter hedge(std::uint32_t seed, float albedo);       // leaves
Painter planks(std::uint32_t seed, float albedo, float width, float height);  // a crate's side, m
Painter water(std::uint32_t seed, float albedo);
Painter clouds(std::uint32_t seed, float size);  // a sky of `size` m, paler towards its borders

// Above any of the worlds.
Quad cloudy_sky(std::uint32_t seed);

// A facade of `width` x `height` m: windows in rows of storeys and a door, set into `ground`.
Painter facade(std::uint32_t seed, float width, float height, Painter ground);

// Square tiles of `side` m with joints: all show the same part of `tile`.
Painter tiles(float side, Painter tile);

// A poster with a heading and lines of print, in the middle (x, y) of a wall.
Painter poster(std::uint32_t seed, float x, float y, Painter ground);

}  // namespace eifmap::simulation
