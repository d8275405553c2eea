#include "map/audit.h"

#include <algorithm>
#include <set>
#include <utility>

namespace eifmap {
namespace {

using Measurement = std::pair<int, int>;  // keyframe, keypoint

std::string named(const Measurement& m) {
  return "keypoint " + std::to_string(m.second) + " of keyframe " + std::to_string(m.first);
}

void audit_tracks(const Map& map, std::set<Measurement>& tracked,
                  std::vector<std::string>& problems) {
  for (int t = 0; t < map.num_tracks(); ++t)
    for (const Sight& s : map.track(t).sights) {
      if (!tracked.insert({s.keyframe, s.keypoint}).second)
        problems.push_back(named({s.keyframe, s.keypoint}) + " is in two tracks");
      if (map.keyframe(s.keyframe).track[s.keypoint] != t)
        problems.push_back(named({s.keyframe, s.keypoint}) + " does not know its track");
    }
}

void audit_edges(const Map& map, const std::set<Measurement>& tracked,
                 std::vector<std::string>& problems) {
  std::set<Measurement> spent;
  for (const MapEdge& edge : map.edges())
    for (const Match& match : edge.matches)
      for (const Measurement& m : {Measurement{edge.i, match.a}, Measurement{edge.j, match.b}}) {
        if (!spent.insert(m).second) problems.push_back(named(m) + " is in two edges");
        if (tracked.contains(m)) problems.push_back(named(m) + " is in an edge and in a track");
      }
  for (int k = 0; k < map.num_keyframes(); ++k)
    for (int keypoint = 0; keypoint < map.keyframe(k).observed().size(); ++keypoint)
      if ((map.keyframe(k).spent[keypoint] != 0) != spent.contains({k, keypoint}))
        problems.push_back(named({k, keypoint}) + " is not marked as its edges have it");
}

void audit_filter(const Map& map, std::vector<std::string>& problems) {
  for (int t = 0; t < map.num_tracks(); ++t) {
    const Track& track = map.track(t);
    if (!track.is_landmark()) continue;
    std::vector<int> poses, keyframes;
    for (const PointMeasurement& m : map.filter().landmark(track.landmark).measurements)
      poses.push_back(m.pose);
    for (const Sight& s : track.sights) keyframes.push_back(s.keyframe);
    std::sort(poses.begin(), poses.end());
    if (poses != keyframes)
      problems.push_back("the filter does not hold the sights of track " + std::to_string(t));
  }
}

void audit_places(const Map& map, std::vector<std::string>& problems) {
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (map.places().contains(k) == map.is_removed(k))
      problems.push_back("the index of places does not know what became of keyframe " +
                         std::to_string(k));
  if (map.places().size() != map.num_keyframes_in_use())
    problems.push_back("the index of places has another number of keyframes");
}

}  // namespace

std::vector<std::string> audit(const Map& map) {
  std::vector<std::string> problems;
  std::set<Measurement> tracked;
  audit_tracks(map, tracked, problems);
  audit_edges(map, tracked, problems);
  audit_filter(map, problems);
  audit_places(map, problems);
  return problems;
}

}  // namespace eifmap
