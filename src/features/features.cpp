#include "features/features.h"

#include <algorithm>
#include <tuple>

#include "features/feature_spread.h"

namespace eifmap {
namespace {

bool comes_before(const Keypoint& a, const Keypoint& b) {
  return std::tuple(-a.response, a.v, a.u, a.scale) < std::tuple(-b.response, b.v, b.u, b.scale);
}

}  // namespace

std::vector<std::size_t> best_keypoints(std::span<const Keypoint> keypoints, int width, int height,
                                        std::size_t count) {
  std::vector<Contender> contenders;
  contenders.reserve(keypoints.size());
  for (const Keypoint& k : keypoints)
    contenders.push_back({k.u, k.v, k.response, k.laplacian_sign});
  std::vector<std::size_t> kept = spread(contenders, width, height, count);
  std::sort(kept.begin(), kept.end(),
            [&](std::size_t a, std::size_t b) { return comes_before(keypoints[a], keypoints[b]); });
  return kept;
}

}  // namespace eifmap
