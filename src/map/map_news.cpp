#include "map/map_news.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace eifmap {
namespace {

// Relative to the depth: below what any user of the map can tell.
constexpr double kKeyframeMoved = 1e-3, kLandmarkMoved = 1e-2;
constexpr double kMovedSigmas = 0.25, kMovedPx = 0.5;
constexpr double kCovarianceChanged = 0.1;  // of the summed variances
// Landmarks that are asked in each update whether their covariance has changed, besides those that
// have reason to.
constexpr int kInTurn = 50;

bool moved(const Rigid3& a, const Rigid3& b, double depth) {
  return (a.translation - b.translation).norm() > kKeyframeMoved * depth ||
         so3_log(a.rotation.conjugate() * b.rotation).norm() > kKeyframeMoved;
}

KeyframeView keyframe_view(const Map& map, int keyframe) {
  return {keyframe, map.keyframe(keyframe).time_us, map.pose(keyframe), unknown_covariance<6>()};
}

LandmarkView landmark_view(const Map& map, int track) {
  const Track& t = map.track(track);
  LandmarkView landmark;
  landmark.id = track;
  landmark.anchor = t.sights.front().keyframe;
  landmark.position_in_anchor = map.pose(t.sights.front().keyframe).inverse() * map.position(track);
  const Sight& sight = t.sights.front();
  landmark.laplacian_sign =
      map.keyframe(sight.keyframe).observed().frame.keypoints[sight.keypoint].laplacian_sign;
  landmark.num_observations = static_cast<int>(t.sights.size());
  return landmark;
}

// Whether a keyframe that sees the landmark sees it elsewhere.
bool moved_in_view(const Map& map, int track, const Eigen::Vector3d& before,
                   const Eigen::Vector3d& now) {
  const double least = kMovedPx * map.radians_per_pixel();
  const std::vector<Sight>& sights = map.track(track).sights;
  return std::any_of(sights.begin(), sights.end(), [&](const Sight& sight) {
    const Rigid3 camera_from_map = map.pose(sight.keyframe).inverse();
    const Eigen::Vector3d a = camera_from_map * before, b = camera_from_map * now;
    return a.cross(b).norm() > least * a.norm() * b.norm();
  });
}

bool moved_by_sigmas(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& step) {
  if (!covariance.allFinite()) return true;
  return step.dot(covariance.ldlt().solve(step)) > kMovedSigmas * kMovedSigmas;
}

bool moved(const Map& map, const LandmarkView& sent, const LandmarkView& now) {
  if (sent.anchor != now.anchor) return true;
  if (sent.position_in_anchor == now.position_in_anchor) return false;
  if ((sent.position_in_anchor - now.position_in_anchor).norm() >
      kLandmarkMoved * now.position_in_anchor.norm())
    return true;
  const Rigid3& anchor = map.pose(static_cast<int>(now.anchor));
  const Eigen::Vector3d before = anchor * sent.position_in_anchor,
                        after = anchor * now.position_in_anchor;
  return moved_by_sigmas(sent.covariance, after - before) ||
         moved_in_view(map, static_cast<int>(now.id), before, after);
}

bool same_sights(const std::vector<Sight>& a, const std::vector<Sight>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Sight& x, const Sight& y) {
    return x.keyframe == y.keyframe && x.keypoint == y.keypoint;
  });
}

ObservationView observation_view(const Map& map, int track, const Sight& sight) {
  const Keypoint& k = map.keyframe(sight.keyframe).observed().frame.keypoints[sight.keypoint];
  return {sight.keyframe, track, k.u, k.v};
}

bool covariance_changed(const Eigen::Matrix3d& sent, const Eigen::Matrix3d& now) {
  if (!sent.allFinite() || !now.allFinite()) return sent.allFinite() != now.allFinite();
  return std::abs(now.trace() - sent.trace()) > kCovarianceChanged * sent.trace();
}

void add_covariances(const Map& map, MapUpdate& update) {
  std::vector<int> poses, landmarks;
  for (const KeyframeView& k : update.keyframes)
    if (!map.is_removed(static_cast<int>(k.id))) poses.push_back(static_cast<int>(k.id));
  for (const LandmarkView& l : update.landmarks)
    landmarks.push_back(map.track(static_cast<int>(l.id)).landmark);
  std::vector<PoseBlock> of_poses;
  std::vector<Eigen::Matrix3d> of_landmarks;
  if (!map.filter().covariances(poses, landmarks, of_poses, of_landmarks)) return;
  std::size_t next = 0;
  for (KeyframeView& k : update.keyframes)
    if (!map.is_removed(static_cast<int>(k.id))) k.covariance = centre_first(of_poses[next++]);
  for (std::size_t l = 0; l < landmarks.size(); ++l)
    update.landmarks[l].covariance = of_landmarks[l];
}

}  // namespace

std::vector<KeyframeView> keyframe_views(const Map& map) {
  MapUpdate all;
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (!map.is_removed(k)) all.keyframes.push_back(keyframe_view(map, k));
  add_covariances(map, all);
  return std::move(all.keyframes);
}

std::vector<LandmarkView> landmark_views(const Map& map) {
  MapUpdate all;
  for (int t = 0; t < map.num_tracks(); ++t)
    if (map.track(t).is_landmark()) all.landmarks.push_back(landmark_view(map, t));
  add_covariances(map, all);
  return std::move(all.landmarks);
}

void MapNews::compare_keyframes(const Map& map, MapUpdate& update) {
  for (int k = 0; k < map.num_keyframes(); ++k) {
    const bool fresh = k >= static_cast<int>(sent_poses_.size());
    // A removed one is still the place that frames refer to.
    const int seen_from = map.is_removed(k) ? map.keyframe(k).carrier : k;
    if (!fresh && !moved(sent_poses_[k], map.pose(k), map.median_depth(seen_from))) continue;
    update.keyframes.push_back(keyframe_view(map, k));
    if (fresh) sent_poses_.emplace_back();
    sent_poses_[k] = map.pose(k);
  }
}

// Returns whether they are others than before.
bool MapNews::compare_sights(const Map& map, int track, Sent& sent, MapUpdate& update) {
  const std::vector<Sight>& now = map.track(track).sights;
  if (same_sights(sent.sights, now)) return false;
  auto old = sent.sights.begin();
  const auto remove_old = [&] {
    update.removed_observations.push_back({old->keyframe, track});
    ++old;
  };
  for (const Sight& sight : now) {  // both by keyframe ascending
    while (old != sent.sights.end() && old->keyframe < sight.keyframe) remove_old();
    const bool known = old != sent.sights.end() && old->keyframe == sight.keyframe;
    if (!known || old->keypoint != sight.keypoint)
      update.observations.push_back(observation_view(map, track, sight));
    if (known) ++old;
  }
  while (old != sent.sights.end()) remove_old();
  sent.sights = now;
  return true;
}

bool MapNews::is_its_turn(int track) const {
  return track >= turn_ && track < turn_ + kInTurn;
}

void MapNews::compare_landmarks(const Map& map, MapUpdate& update) {
  for (int t = 0; t < map.num_tracks(); ++t) {
    const auto known = sent_.find(t);
    if (!map.track(t).is_landmark()) {
      if (known == sent_.end()) continue;
      update.removed_landmarks.push_back(t);
      sent_.erase(known);
      continue;
    }
    const LandmarkView now = landmark_view(map, t);
    Sent& sent = sent_[t];
    const bool seen_anew = compare_sights(map, t, sent, update);
    if (known != sent_.end() && !seen_anew && !is_its_turn(t) && !moved(map, sent.landmark, now))
      continue;
    update.landmarks.push_back(now);
  }
  turn_ = turn_ + kInTurn < map.num_tracks() ? turn_ + kInTurn : 0;
}

// Of those that were looked at, with their covariances, what is worth being sent.
void MapNews::keep_changed(const Map& map, MapUpdate& update) {
  std::erase_if(update.landmarks, [&](const LandmarkView& now) {
    Sent& sent = sent_.at(now.id);
    const bool is_new = sent.landmark.laplacian_sign == 0;
    if (!is_new && !moved(map, sent.landmark, now) &&
        !covariance_changed(sent.landmark.covariance, now.covariance))
      return true;
    sent.landmark = now;
    return false;
  });
}

void MapNews::begin_anew() {
  sent_poses_.clear();
  sent_.clear();
  is_whole_ = true;
}

MapUpdate MapNews::since_last(const Map& map) {
  MapUpdate update;
  update.base_seq = std::exchange(is_whole_, false) ? -1 : seq_;
  update.seq = ++seq_;
  compare_keyframes(map, update);
  compare_landmarks(map, update);
  add_covariances(map, update);
  keep_changed(map, update);
  return update;
}

}  // namespace eifmap
