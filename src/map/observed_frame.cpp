#include "map/observed_frame.h"

namespace eifmap {

ObservedFrame observe(const FeatureFrame& frame, const Camera& camera, MapSign map_sign,
                      double sigma_factor) {
  ObservedFrame observed;
  observed.frame = frame;
  observed.map_sign = map_sign;
  observed.x.reserve(frame.keypoints.size());
  observed.sigma.reserve(frame.keypoints.size());
  for (const Keypoint& keypoint : frame.keypoints) {
    observed.x.push_back(camera.normalized_from_pixel({keypoint.u, keypoint.v}));
    observed.sigma.push_back(sigma_factor * keypoint.sigma_px * camera.radians_per_pixel());
  }
  observed.minus = features_of_sign(frame, -1);
  observed.plus = features_of_sign(frame, 1);
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
