#include "map/redundancy.h"

#include "map/map_scale.h"

namespace eifmap {

double redundancy(const Map& map, int keyframe, int enough_views) {
  int landmarks = 0, redundant = 0;
  for (const int t : map.keyframe(keyframe).track) {
    if (t == kNoTrack || !map.track(t).is_landmark()) continue;
    ++landmarks;
    redundant += static_cast<int>(map.track(t).sights.size()) > enough_views;
  }
  return landmarks == 0 ? 1 : static_cast<double>(redundant) / landmarks;
}

std::optional<int> redundant_keyframe(const Map& map, int reference,
                                      const KeyframeOptions& options) {
  std::optional<int> found;
  double most = options.redundant_share;
  const std::vector<int> shared = map.num_shared(reference);
  for (int k = 2; k < map.num_keyframes() - options.keep_newest; ++k) {
    if (shared[k] == 0) continue;
    const double share = redundancy(map, k, options.enough_views);
    if (share < most || (found && share == most) || !is_spare(map, k)) continue;
    most = share;
    found = k;
  }
  return found;
}

}  // namespace eifmap
