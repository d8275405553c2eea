#include "map/loop_join.h"

#include <algorithm>

#include "map/guided_search.h"
#include "map/pose_search.h"

namespace eifmap {
namespace {

// Whether all of the track's sights are near where they would see the point.
bool fits(const Map& map, int track, const Eigen::Vector3d& point, double radius) {
  const std::vector<Sight>& sights = map.track(track).sights;
  return std::all_of(sights.begin(), sights.end(), [&](const Sight& s) {
    Eigen::Vector2d x;
    return project(map.pose(s.keyframe), point, x) &&
           (x - map.keyframe(s.keyframe).observed().x[s.keypoint]).norm() <= radius;
  });
}

bool join(Map& map, int landmark, const Sight& sight) {
  const int own = map.keyframe(sight.keyframe).track[sight.keypoint];
  return own == kNoTrack ? map.add_sight(landmark, sight) : map.join_tracks(landmark, own);
}

std::vector<int> without(const std::vector<int>& tracks, const std::vector<int>& others) {
  std::vector<int> left;
  std::set_difference(tracks.begin(), tracks.end(), others.begin(), others.end(),
                      std::back_inserter(left));
  return left;
}

// Landmarks that the keyframe does not see yet, looked for in it.
int join_into(Map& map, int keyframe, const std::vector<int>& landmarks,
              const MapperOptions& options) {
  std::vector<int> present;
  for (int t : landmarks)
    if (map.track(t).is_landmark()) present.push_back(t);  // and has not just been joined
  const double radius = search_radius(map, options);
  SearchGate gate;
  gate.radius = radius;
  const std::vector<LandmarkSight> found =
      search_landmarks(map, map.keyframe(keyframe).observed(), map.pose(keyframe),
                       without(present, map.landmarks_of({keyframe})), gate, options.match);
  int joined = 0;
  for (const LandmarkSight& s : found) {
    if (!map.track(s.track).is_landmark()) continue;
    const int own = map.keyframe(keyframe).track[s.keypoint];
    // A feature that an edge has used, or of the other sign, is not one of the map's.
    if (!map.keyframe(keyframe).observed().in_omega_m(s.keypoint)) continue;
    if (own != kNoTrack && !fits(map, own, map.position(s.track), radius)) continue;
    joined += join(map, s.track, {keyframe, s.keypoint}) ? 1 : 0;
  }
  return joined;
}

}  // namespace

int join_sights(Map& map, int newest, const std::vector<LandmarkSight>& sights) {
  int joined = 0;
  for (const LandmarkSight& s : sights) {
    if (!map.track(s.track).is_landmark()) continue;
    if (!map.keyframe(newest).observed().in_omega_m(s.keypoint)) continue;
    joined += join(map, s.track, {newest, s.keypoint}) ? 1 : 0;
  }
  return joined;
}

int join_passes(Map& map, const std::vector<int>& here, const std::vector<int>& there,
                const MapperOptions& options) {
  const std::vector<int> of_here = map.landmarks_of(here), of_there = map.landmarks_of(there);
  int joined = 0;
  for (int k : here) joined += join_into(map, k, of_there, options);
  for (int k : there) joined += join_into(map, k, of_here, options);
  return joined;
}

}  // namespace eifmap
