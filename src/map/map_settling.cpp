#include "map/map_settling.h"

#include <algorithm>
#include <limits>

namespace eifmap {

bool settle(Map& map) {
  constexpr int kSteps = 8;
  constexpr double kNear = 1;  // squared sigmas
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kSteps; ++k) {
    const WholeIteration step = map.filter().iterate_whole();
    if (!step.ok || !(step.squared_step <= before)) return false;
    if (step.squared_step <= kNear) return true;
    before = step.squared_step;
  }
  return true;
}

int sights_left(const Map& map, int keyframe, const std::vector<LandmarkSight>& sights) {
  return static_cast<int>(std::count_if(sights.begin(), sights.end(), [&](const LandmarkSight& s) {
    return map.keyframe(keyframe).track[s.keypoint] == s.track && map.track(s.track).is_landmark();
  }));
}

}  // namespace eifmap
