#include <algorithm>
#include <cmath>

#include "map/epipolar_match.h"
#include "map/keyframe_insertion.h"

namespace eifmap {
namespace {

// A measurement enters one edge only, and none that the map has as a feature's.
std::vector<std::uint8_t> taken(const Keyframe& keyframe) {
  std::vector<std::uint8_t> taken = keyframe.spent;
  for (std::size_t k = 0; k < taken.size(); ++k) taken[k] |= keyframe.track[k] != kNoTrack;
  return taken;
}

// Free on both sides, then every n-th so that the edge's share is spread over the image (matches
// come in the order of the features' response).
std::vector<Match> choose_free(const Map& map, int i, int j, const std::vector<Match>& matches,
                               const EdgeOptions& options) {
  std::vector<Match> free;
  std::vector<std::uint8_t> taken_i = taken(map.keyframe(i)), taken_j = taken(map.keyframe(j));
  for (const Match& match : matches) {
    if (taken_i[match.a] || taken_j[match.b]) continue;
    taken_i[match.a] = taken_j[match.b] = 1;  // matches need not be mutual
    free.push_back(match);
  }
  const auto share = static_cast<std::size_t>(options.max_spent_ratio * matches.size());
  const std::size_t wanted =
      std::max<std::size_t>(share, static_cast<std::size_t>(options.min_measurements) * 6 / 5);
  if (free.size() <= wanted) return free;
  std::vector<Match> chosen;
  for (std::size_t k = 0; k < wanted; ++k) chosen.push_back(free[k * free.size() / wanted]);
  return chosen;
}

}  // namespace

bool add_edge(Map& map, int i, int j, const std::vector<Match>& matches, RelativePose start,
              const MapperOptions& options) {
  const std::vector<Match> chosen = choose_free(map, i, j, matches, options.edge);
  if (static_cast<int>(chosen.size()) < options.edge.min_measurements) return false;
  const ObservedFrame& frame_i = map.keyframe(i).observed();
  const ObservedFrame& frame_j = map.keyframe(j).observed();
  std::vector<Correspondence> pairs;
  for (const Match& match : chosen) pairs.push_back(correspondence(frame_i, frame_j, match));
  std::vector<std::uint8_t> inlier;
  if (!refine_relative_pose(pairs, start, inlier, options.relative_pose.covariance)) return false;
  const auto agreeing = std::count(inlier.begin(), inlier.end(), 1);
  constexpr double kDegree = M_PI / 180;
  if (agreeing < options.edge.min_measurements ||
      !(start.sigma_direction < options.edge.max_sigma_direction_deg * kDegree))
    return false;
  if (!map.filter().add_edge(i, j, start)) return false;
  map.spend({i, j, chosen});  // the outliers too: those near the limit had a part in R and T
  return true;
}

bool add_edge_from_map(Map& map, int i, int j, const MapperOptions& options) {
  const auto free = [&map](int k) {
    const std::vector<std::uint8_t> is_taken = taken(map.keyframe(k));
    std::vector<int> keypoints;
    for (int keypoint = 0; keypoint < map.keyframe(k).observed().size(); ++keypoint)
      if (!map.keyframe(k).observed().in_omega_m(keypoint) && !is_taken[keypoint])
        keypoints.push_back(keypoint);
    return keypoints;
  };
  // Wide enough that the map's own error does not choose the matches.
  constexpr double kMaxError = 6;
  const std::vector<Match> matches = match_along_epipolar_lines(
      map.keyframe(i).observed(), free(i), map.keyframe(j).observed(), free(j), map.pose(i),
      map.pose(j), {kMaxError, options.match.max_ratio, options.match.max_distance});
  const Rigid3 i_from_j = map.pose(i).inverse() * map.pose(j);
  RelativePose start;
  start.i_from_j = i_from_j.rotation;
  start.direction = i_from_j.translation.normalized();
  return add_edge(map, i, j, matches, start, options);
}

}  // namespace eifmap
