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

std::vector<Keypoint> keep_best(const std::vector<Keypoint>& keypoints, int width, int height,
                                std::size_t count) {
  std::vector<Contender> contenders;
  contenders.reserve(keypoints.size());
  for (const Keypoint& k : keypoints)
    contenders.push_back({k.u, k.v, k.response, k.laplacian_sign});
  std::vector<Keypoint> kept;
  for (const std::size_t i : spread(contenders, width, height, count)) kept.push_back(keypoints[i]);
  std::sort(kept.begin(), kept.end(), comes_before);
  return kept;
}

}  // namespace eifmap
