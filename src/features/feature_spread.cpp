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

bool better(const Ranked& a, const Ranked& b) {
  return a.merit != b.merit ? a.merit > b.merit : a.index < b.index;
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

  std::vector<Ranked> ranked(contenders.size());
  for (std::size_t i = 0; i < ranked.size(); ++i) ranked[i] = {contenders[i].response, i};
  std::sort(ranked.begin(), ranked.end(), better);

  std::vector<int> rank(2 * columns * rows, 0);
  for (Ranked& r : ranked) r.merit /= ++rank[tile_of(contenders[r.index], side, columns)];
  const std::size_t kept = std::min(count, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(kept),
                    ranked.end(), better);
  std::vector<std::size_t> order(kept);
  for (std::size_t i = 0; i < kept; ++i) order[i] = ranked[i].index;
  return order;
}

}  // namespace eifmap
