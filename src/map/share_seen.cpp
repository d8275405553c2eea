#include "map/share_seen.h"

#include <algorithm>
#include <utility>

#include "geometry/projection.h"
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

struct Place {
  Eigen::Vector2d x;  // normalized image coordinates
  bool seen = false;
};

int count_in_holes(const std::vector<Place>& places) {
  constexpr std::size_t kNext = 7;  // itself among them
  if (places.size() < kNext) return 0;
  int in_holes = 0;
  std::vector<std::pair<double, std::size_t>> near(places.size());
  for (const Place& place : places) {
    if (place.seen) continue;
    for (std::size_t i = 0; i < places.size(); ++i)
      near[i] = {(places[i].x - place.x).squaredNorm(), i};
    std::nth_element(near.begin(), near.begin() + kNext - 1, near.end());
    in_holes += std::none_of(near.begin(), near.begin() + kNext,
                             [&](const auto& other) { return places[other.second].seen; });
  }
  return in_holes;
}

}  // namespace

bool SeenAgain::is_all_over(const LostOptions& options) const {
  constexpr double kInHoles = 0.1;  // of those expected: of 30 % that are seen, at random, 8 % are
  return share() >= options.min_share_seen && in_holes <= kInHoles * expected;
}

SeenAgain seen_again(const Map& map, int keyframe, const ObservedFrame& observed,
                     const Rigid3& world_from_camera, const SafeView& view,
                     const MapperOptions& options, int around) {
  const std::vector<int> expected =
      landmarks_expected(map, view, world_from_camera,
                         seen_well(map, map.landmarks_of(map.covisible(keyframe, around))));
  SearchGate gate;
  gate.radius = search_radius(map, options);
  const std::vector<LandmarkSight> found =
      search_landmarks(map, observed, world_from_camera, expected, gate, options.match);
  std::vector<Place> places;
  auto next = found.begin();  // both by track
  for (const int t : expected) {
    Place place;
    project(world_from_camera, map.position(t), place.x);
    while (next != found.end() && next->track < t) ++next;
    place.seen = next != found.end() && next->track == t;
    places.push_back(place);
  }
  return {static_cast<int>(expected.size()), static_cast<int>(found.size()),
          count_in_holes(places)};
}

}  // namespace eifmap
