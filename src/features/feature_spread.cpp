#include "features/feature_spread.h"

#include <algorithm>
#include <cmath>

namespace eifmap {
namespace {

constexpr double kFeaturesPerTile = 8;

std::size_t tile_of(const Contender& c, double side, std::size_t columns) {
  const std::size_t tile = static_cast<std::size_t>(std::max(0.0f, c.v) / side) * columns +
                           static_cast<std::size_t>(std::max(0.0f, c.u) / side);
  return 2 * tile + (c.sign > 0 ? 1 : 0);
}

struct Ranked {
  double merit;
  std::size_t index;
};

// Whether the first is better.
struct Better {
  bool operator()(const Ranked& a, const Ranked& b) const {
    return a.merit != b.merit ? a.merit > b.merit : a.index < b.index;
  }
};

// Each contender's response over its rank among those of its tile and sign. Tile by tile: sorting
// many small sets takes half the time of sorting a large one.
std::vector<Ranked> rank_within_tiles(std::span<const Contender> contenders,
                                      const std::vector<std::size_t>& tiles, std::size_t count) {
  std::vector<std::size_t> begin(count + 1, 0);
  for (const std::size_t tile : tiles) ++begin[tile + 1];
  for (std::size_t t = 0; t < count; ++t) begin[t + 1] += begin[t];
  std::vector<Ranked> ranked(contenders.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0; i < tiles.size(); ++i)
    ranked[next[tiles[i]]++] = {contenders[i].response, i};
  for (std::size_t t = 0; t < count; ++t) {
    const std::span<Ranked> tile(ranked.data() + begin[t], begin[t + 1] - begin[t]);
    std::sort(tile.begin(), tile.end(), Better());
    for (std::size_t n = 0; n < tile.size(); ++n) tile[n].merit /= static_cast<double>(n + 1);
  }
  return ranked;
}

}  // namespace

std::vector<std::size_t> spread(std::span<const Contender> contenders, int width, int height,
                                std::size_t count) {
  const double area = static_cast<double>(width) * height;
  const double side = std::max(
      8.0,
      std::sqrt(area * kFeaturesPerTile / static_cast<double>(std::max<std::size_t>(1, count))));
  const std::size_t columns = static_cast<std::size_t>(width / side) + 1;
  const std::size_t rows = static_cast<std::size_t>(height / side) + 1;

  std::vector<std::size_t> tiles(contenders.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i] = tile_of(contenders[i], side, columns);
  std::vector<Ranked> ranked = rank_within_tiles(contenders, tiles, 2 * columns * rows);
  const std::size_t kept = std::min(count, ranked.size());
  const auto end = ranked.begin() + static_cast<std::ptrdiff_t>(kept);
  if (kept < ranked.size()) std::nth_element(ranked.begin(), end, ranked.end(), Better());
  std::sort(ranked.begin(), end, Better());
  std::vector<std::size_t> order(kept);
  for (std::size_t i = 0; i < kept; ++i) order[i] = ranked[i].index;
  return order;
}

}  // namespace eifmap
