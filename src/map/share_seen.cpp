#include "map/share_seen.h"

#include <vector>

#include "map/guided_search.h"
#include "map/pose_search.h"

namespace eifmap {
namespace {

std::vector<int> seen_well(const Map& map, const std::vector<int>& tracks) {
  constexpr std::size_t kEnough = 3;
  std::vector<int> found;
  for (const int t : tracks)
    if (map.track(t).sights.size() >= kEnough) found.push_back(t);
  return found;
}

}  // namespace

double share_seen(const Map& map, int keyframe, const ObservedFrame& observed,
                  const Rigid3& world_from_camera, const SafeView& view,
                  const MapperOptions& options) {
  constexpr int kLocal = 12;  // keyframes
  const std::vector<int> around = map.landmarks_of(map.covisible(keyframe, kLocal));
  const std::vector<int> expected =
      landmarks_expected(map, view, world_from_camera, seen_well(map, around));
  if (expected.empty()) return 0;
  SearchGate gate;
  gate.radius = search_radius(map, options);
  const auto seen =
      search_landmarks(map, observed, world_from_camera, expected, gate, options.match).size();
  return static_cast<double>(seen) / static_cast<double>(expected.size());
}

}  // namespace eifmap
