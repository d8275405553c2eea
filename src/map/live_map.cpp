#include "map/live_map.h"

#include <algorithm>
#include <utility>

#include "map/near_keyframes.h"

namespace eifmap {

LiveMap::LiveMap(Map started, const Camera& camera)
    : current(std::make_shared<Map>(std::move(started))), sight_counts(camera) {
  most_tracked.assign(static_cast<std::size_t>(map().num_keyframes()), map().num_landmarks());
}

void LiveMap::make_metric(double metres_per_unit) {
  log.make_metric(metres_per_unit);
  sight_counts.make_metric(metres_per_unit);
  last.pose.translation *= metres_per_unit;
  last.step *= metres_per_unit;
}

void LiveMap::grow(const std::vector<double>& growth) {
  log.grow(growth);
  sight_counts.forget_last();
}

void LiveMap::include(const LiveMap& other, const Appended& appended, bool newest) {
  log.include(other.log, appended, newest);
  sight_counts.include(other.sight_counts, appended);
  most_tracked.insert(most_tracked.end(), other.most_tracked.begin(), other.most_tracked.end());
  loop_search = {};
  removed_keyframes += other.removed_keyframes;
  removed_landmarks += other.removed_landmarks;
}

void LiveMap::follow(LiveMap&& other, const Appended& appended) {
  news = std::move(other.news);
  update = std::move(other.update);
  history = std::move(other.history);
  reference = appended.first_keyframe + other.reference;
}

FinishedMap finish(const LiveMap& live) {
  FinishedMap finished;
  const Map& map = live.map();
  finished.trajectory = live.log.in(map);
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (!map.is_removed(k)) finished.keyframes.push_back({map.keyframe(k).time_us, map.pose(k)});
  for (int t = 0; t < map.num_tracks(); ++t) {
    const Track& track = map.track(t);
    if (!track.is_landmark()) continue;
    const Sight& s = track.sights.front();
    finished.points.push_back(
        {map.position(t),
         map.keyframe(s.keyframe).observed().frame.keypoints[s.keypoint].laplacian_sign,
         static_cast<int>(track.sights.size())});
  }
  return finished;
}

std::vector<int> keyframes_to_try(LiveMap& live, const FeatureFrame& frame, int places,
                                  const std::vector<int>& likely) {
  constexpr int kOthers = 3;
  const Map& map = live.map();
  std::vector<int> keyframes;
  for (const PlaceScore& place : map.places().query(frame, places)) keyframes.push_back(place.id);
  const int others = std::max(1, kOthers - static_cast<int>(keyframes.size()));
  const auto add = [&keyframes](int k) {
    if (std::find(keyframes.begin(), keyframes.end(), k) == keyframes.end()) keyframes.push_back(k);
  };
  for (const int k : likely) add(k);
  for (int i = 0; i < others; ++i) {
    while (map.is_removed(live.next_to_try % map.num_keyframes())) ++live.next_to_try;
    add(live.next_to_try++ % map.num_keyframes());
  }
  return keyframes;
}

int better_reference(const Map& map, const Tracking& tracking) {
  const std::vector<int> shared = num_seen(map, tracking.sights);
  int best = tracking.reference;
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (shared[k] > 1.2 * shared[tracking.reference] && shared[k] > shared[best]) best = k;
  return best;
}

}  // namespace eifmap
