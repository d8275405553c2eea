#include "map/observed_frame.h"

#include <algorithm>

namespace eifmap {
namespace {

// Keeps the keypoints whose flag says so.
void keep(const std::vector<bool>& kept, FeatureFrame& frame) {
  std::size_t next = 0;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    if (!kept[k]) continue;
    frame.keypoints[next] = frame.keypoints[k];
    const auto descriptor =
        frame.descriptors.begin() + static_cast<std::ptrdiff_t>(k * kDescriptorSize);
    std::copy_n(descriptor, kDescriptorSize,
                frame.descriptors.begin() + static_cast<std::ptrdiff_t>(next * kDescriptorSize));
    ++next;
  }
  frame.keypoints.resize(next);
  frame.descriptors.resize(next * kDescriptorSize);
}

}  // namespace

ObservedFrame observe(const FeatureFrame& frame, const Camera& camera, MapSign map_sign,
                      double sigma_factor) {
  ObservedFrame observed;
  observed.frame = frame;
  observed.map_sign = map_sign;
  observed.sigma_factor = sigma_factor;
  observed.x.reserve(frame.keypoints.size());
  observed.sigma.reserve(frame.keypoints.size());
  std::vector<bool> in_view;
  in_view.reserve(frame.keypoints.size());
  for (const Keypoint& keypoint : frame.keypoints) {
    const Eigen::Vector2d x = camera.normalized_from_pixel({keypoint.u, keypoint.v});
    in_view.push_back(x.allFinite());
    if (!in_view.back()) continue;
    observed.x.push_back(x);
    observed.sigma.push_back(sigma_factor * keypoint.sigma_px * camera.radians_per_pixel_at(x));
  }
  if (observed.size() < static_cast<int>(in_view.size())) keep(in_view, observed.frame);
  observed.minus = features_of_sign(observed.frame, -1);
  observed.plus = features_of_sign(observed.frame, 1);
  return observed;
}

std::vector<Match> match_omega_m(const ObservedFrame& i, const ObservedFrame& j,
                                 const MatchOptions& options) {
  if (i.map_sign == MapSign::kPlus) return match(i.plus, j.plus, options);
  std::vector<Match> matches = match(i.minus, j.minus, options);
  if (i.map_sign == MapSign::kMinus) return matches;
  const std::vector<Match> more = match(i.plus, j.plus, options);
  matches.insert(matches.end(), more.begin(), more.end());
  return matches;
}

std::vector<Match> match_omega_p(const ObservedFrame& i, const ObservedFrame& j,
                                 const MatchOptions& options) {
  if (i.map_sign == MapSign::kBoth) return {};
  return i.map_sign == MapSign::kPlus ? match(i.minus, j.minus, options)
                                      : match(i.plus, j.plus, options);
}

}  // namespace eifmap
