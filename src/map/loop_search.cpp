#include "map/loop_search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "map/pose_search.h"

namespace eifmap {
namespace {

constexpr int kAround = 6;  // keyframes of a place, the one itself among them

bool contains(const std::vector<int>& all, int k) {
  return std::find(all.begin(), all.end(), k) != all.end();
}

// How far the keyframe may be from where the map has it, with what it sees in reach.
double reach(const Map& map, int keyframe) {
  constexpr double kSigmas = 4;
  PoseBlock covariance;
  if (!map.filter().pose_covariance(keyframe, covariance)) return 0;
  const Eigen::Matrix3d of_centre = covariance.bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(of_centre);
  return kSigmas * std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff())) +
         map.median_depth(keyframe);
}

int landmarks_matched(const Map& map, int old, int newest, const MapperOptions& options) {
  const std::vector<Match> matches =
      match_omega_m(map.keyframe(old).observed(), map.keyframe(newest).observed(), options.match);
  return static_cast<int>(landmarks_among(map, old, matches).size());
}

}  // namespace

std::vector<char> may_close(const Map& map, int newest, const LoopOptions& options) {
  std::vector<char> allowed(static_cast<std::size_t>(map.num_keyframes()), 1);
  for (int k : map.covisible(newest, kAround)) {
    const std::vector<int> shared = map.num_shared(k);
    for (std::size_t other = 0; other < shared.size(); ++other)
      if (shared[other] > 0) allowed[other] = 0;
  }
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (map.is_removed(k) || k > newest - options.min_gap) allowed[k] = 0;
  return allowed;
}

std::vector<int> places_by_look(const Map& map, const FeatureFrame& frame,
                                const std::vector<char>& allowed, int count) {
  std::vector<int> places;
  for (const PlaceScore& place : map.places().query(frame, map.places().size())) {
    if (static_cast<int>(places.size()) >= count) break;
    if (allowed[static_cast<std::size_t>(place.id)]) places.push_back(place.id);
  }
  return places;
}

std::vector<int> likely_places(const Map& map, int newest, int turn, const LoopOptions& options) {
  const std::vector<char> allowed = may_close(map, newest, options);
  const int count = options.max_candidates;
  std::vector<int> places =
      places_by_look(map, map.keyframe(newest).observed().frame, allowed, (count + 1) / 2);
  const int left = count - static_cast<int>(places.size());
  for (const int k : places_by_position(map, newest, allowed, turn, left))
    if (!contains(places, k)) places.push_back(k);
  return places;
}

std::vector<int> places_by_position(const Map& map, int newest, const std::vector<char>& allowed,
                                    int turn, int count) {
  constexpr double kAlike = 0.5;  // cosine of the angle between the optical axes
  const double within = reach(map, newest);
  const Rigid3& pose = map.pose(newest);
  const Eigen::Vector3d ahead = pose.matrix().col(2);
  std::vector<int> near, others;
  for (int k = 0; k < map.num_keyframes(); ++k) {
    if (!allowed[k]) continue;
    const Rigid3& old = map.pose(k);
    const bool in_reach = (old.translation - pose.translation).norm() < within &&
                          old.matrix().col(2).dot(ahead) > kAlike;
    (in_reach ? near : others).push_back(k);
  }
  // Spread over all that are in reach, elsewhere in each turn.
  std::vector<int> places;
  const auto take = [&](const std::vector<int>& from, std::size_t most) {
    const std::size_t n = std::min(most, from.size());
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t step = (from.size() + n - 1) / n;
      const std::size_t at = i * step + static_cast<std::size_t>(turn) % step;
      places.push_back(from[std::min(at, from.size() - 1)]);
    }
  };
  if (count < 1) return places;
  take(near, static_cast<std::size_t>(std::max(1, count - 1)));
  take(others, static_cast<std::size_t>(count) - std::min<std::size_t>(count, places.size()));
  return places;
}

std::optional<int> LoopSearch::look(const Map& map, int newest, const std::vector<int>& places,
                                    const MapperOptions& options) {
  ++turn_;
  const std::vector<char> allowed = may_close(map, newest, options.loop);
  std::vector<int> around, to_try;
  if (found_ && !map.is_removed(*found_)) around = map.covisible(*found_, 2 * kAround);
  for (int k : around)
    if (allowed[k] && to_try.size() < kAround) to_try.push_back(k);
  int left = options.loop.max_candidates;
  for (int k : places)
    if (allowed[k] && !contains(to_try, k) && left-- > 0) to_try.push_back(k);
  int best = -1, most = options.loop.min_matches - 1;
  for (int k : to_try) {
    const int matched = landmarks_matched(map, k, newest, options);
    if (matched > most) most = matched, best = k;
  }
  if (best < 0) {
    begin_anew();
    return std::nullopt;
  }
  support_ = contains(around, best) ? support_ + 1 : 1;
  found_ = best;
  if (support_ < options.loop.consecutive) return std::nullopt;
  return best;
}

}  // namespace eifmap
