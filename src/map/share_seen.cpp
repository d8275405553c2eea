#include "map/share_seen.h"

#include <algorithm>
#include <cmath>
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

constexpr std::size_t kNext = 4;  // to each other, in the image

int count_in_holes(const std::vector<Place>& places) {
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
  constexpr double kMore = 0.08, kSigmas = 2;
  if (expected == 0) return false;
  const double n = expected, share = seen / n;
  const double by_chance = std::pow(1 - share, static_cast<double>(kNext));
  const double sigma = std::sqrt(by_chance * (1 - by_chance) / n);
  return share >= options.min_share_seen && in_holes <= n * (by_chance + kMore + kSigmas * sigma);
}

std::string SeenAgain::in_words() const {
  return "of " + std::to_string(expected) + " map features that should be seen " +
         std::to_string(seen) + " are, and " + std::to_string(in_holes) + " are where none is";
}

SeenAgain seen_again(const Map& map, int keyframe, const ObservedFrame& observed,
                     const Rigid3& world_from_camera, const SafeView& view,
                     const MapperOptions& options) {
  constexpr int kAround = 12;  // keyframes
  return seen_again(map, map.landmarks_of(map.covisible(keyframe, kAround)), observed,
                    world_from_camera, view, options);
}

SeenAgain seen_again(const Map& map, const std::vector<int>& tracks, const ObservedFrame& observed,
                     const Rigid3& world_from_camera, const SafeView& view,
                     const MapperOptions& options) {
  const std::vector<int> expected =
      landmarks_expected(map, view, world_from_camera, seen_well(map, tracks));
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
