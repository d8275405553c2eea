#include "map/map_news.h"

#include <algorithm>
#include <utility>

namespace eifmap {
namespace {

// Relative to the depth: below what any user of the map can tell.
constexpr double kKeyframeMoved = 1e-3, kLandmarkMoved = 1e-2;

bool moved(const Rigid3& a, const Rigid3& b, double depth) {
  return (a.translation - b.translation).norm() > kKeyframeMoved * depth ||
         so3_log(a.rotation.conjugate() * b.rotation).norm() > kKeyframeMoved;
}

KeyframeView keyframe_view(const Map& map, int keyframe) {
  return {keyframe, map.keyframe(keyframe).observed().frame.time_us, map.pose(keyframe),
          unknown_covariance<6>()};
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

bool changed(const LandmarkView& sent, const LandmarkView& now) {
  return sent.anchor != now.anchor || (sent.position_in_anchor - now.position_in_anchor).norm() >
                                          kLandmarkMoved * now.position_in_anchor.norm();
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
    if (!fresh) {
      sent_poses_[k] = map.pose(k);
      continue;
    }
    sent_poses_.push_back(map.pose(k));
    const FeatureFrame& frame = map.keyframe(k).observed().frame;
    for (std::size_t i = 0; i < frame.keypoints.size(); ++i) {
      const int track = map.keyframe(k).track[i];
      if (track != kNoTrack && map.track(track).is_landmark())
        update.observations.push_back({k, track, frame.keypoints[i].u, frame.keypoints[i].v});
    }
  }
}

void MapNews::compare_landmarks(const Map& map, MapUpdate& update) {
  for (int t = 0; t < map.num_tracks(); ++t) {
    const auto sent = sent_.find(t);
    if (!map.track(t).is_landmark()) {
      if (sent == sent_.end()) continue;
      update.removed_landmarks.push_back(t);
      sent_.erase(sent);
      continue;
    }
    const LandmarkView now = landmark_view(map, t);
    if (sent != sent_.end() && !changed(sent->second, now)) continue;
    sent_[t] = now;
    update.landmarks.push_back(now);
  }
}

void MapNews::begin_anew(std::int64_t seq) {
  seq_ = std::max(seq_, seq);
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
  return update;
}

}  // namespace eifmap
