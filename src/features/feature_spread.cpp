#include "features/feature_spread.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace eifmap {
namespace {

constexpr double kFeaturesPerTile = 8;

std::size_t tile_of(const Contender& c, double side, std::size_t columns) {
  const std::size_t tile = static_cast<std::size_t>(std::max(0.0f, c.v) / side) * columns +
                           static_cast<std::size_t>(std::max(0.0f, c.u) / side);
  return 2 * tile + (c.sign > 0 ? 1 : 0);
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

  std::vector<std::size_t> order(contenders.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return contenders[a].response > contenders[b].response;
  });

  std::vector<int> rank(2 * columns * rows, 0);
  std::vector<double> merit(contenders.size());
  for (const std::size_t i : order) {
    const double n = ++rank[tile_of(contenders[i], side, columns)];
    merit[i] = contenders[i].response / (n * n);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return merit[a] > merit[b]; });
  order.resize(std::min(order.size(), count));
  return order;
}

}  // namespace eifmap
