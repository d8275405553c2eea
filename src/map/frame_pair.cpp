#include "map/frame_pair.h"

namespace eifmap {

std::vector<Match> FramePair::explained_p() const {
  std::vector<Match> explained;
  for (std::size_t k = 0; k < p.size(); ++k)
    if (relative.inlier[k]) explained.push_back(p[k]);
  return explained;
}

FramePair relate(const ObservedFrame& i, const ObservedFrame& j, double radians_per_pixel,
                 const MapperOptions& options) {
  FramePair pair;
  pair.p = match_omega_p(i, j, options.match);
  pair.m = match_omega_m(i, j, options.match);
  std::vector<Correspondence> all;
  all.reserve(pair.p.size() + pair.m.size());
  for (const auto* matches : {&pair.p, &pair.m})
    for (const Match& match : *matches) all.push_back(correspondence(i, j, match));
  pair.relative = estimate_relative_pose(all, radians_per_pixel, options.relative_pose);
  return pair;
}

}  // namespace eifmap
