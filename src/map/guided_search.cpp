#include "map/guided_search.h"

#include <algorithm>
#include <limits>

#include "geometry/projection.h"

namespace eifmap {
namespace {

constexpr int kUnitSquared = 254 * 254;  // squared norm of a descriptor's bytes

struct Candidate {
  int distance = 0, track = 0, keypoint = 0;
};

// Best keypoint near the prediction; ambiguous ones are left alone.
bool best_keypoint(const ObservedFrame& observed, const ObservedFrame& seen_in, int seen_as,
                   const std::vector<int>& near, const MatchOptions& options, Candidate& best) {
  const std::int8_t* descriptor = seen_in.descriptor(seen_as);
  int second = std::numeric_limits<int>::max();
  best.distance = std::numeric_limits<int>::max();
  for (int keypoint : near) {
    if (observed.sign(keypoint) != seen_in.sign(seen_as)) continue;
    const int distance = descriptor_distance(descriptor, observed.descriptor(keypoint));
    if (distance < best.distance) {
      second = best.distance;
      best.distance = distance;
      best.keypoint = keypoint;
    } else {
      second = std::min(second, distance);
    }
  }
  // The place is known, so the ratio may be looser than without a guess.
  const double ratio = 0.5 * (1 + options.max_ratio);
  return best.distance <= options.max_distance * options.max_distance * kUnitSquared &&
         best.distance <= ratio * ratio * second;
}

// Takes out the keypoints whose innovation is too large to be chance.
void keep_likely(const Map& map, const ObservedFrame& observed, const Projector& projector,
                 int track, const SearchGate& gate, std::vector<int>& near) {
  Eigen::Vector2d predicted;
  Eigen::Matrix<double, 2, 6> d_pose;
  Eigen::Matrix<double, 2, 3> d_point;
  projector(map.position(track), predicted, &d_pose, &d_point);
  const Eigen::Matrix2d of_prediction =
      d_pose * *gate.pose_covariance * d_pose.transpose() +
      d_point * map.position_covariance(track) * d_point.transpose();
  std::erase_if(near, [&](int keypoint) {
    const double sigma = observed.sigma[keypoint];
    const Eigen::Matrix2d innovation = of_prediction + sigma * sigma * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d error = observed.x[keypoint] - predicted;
    return error.dot(innovation.inverse() * error) > gate.sigmas * gate.sigmas;
  });
}

}  // namespace

std::vector<LandmarkSight> search_landmarks(const Map& map, const ObservedFrame& observed,
                                            const Rigid3& world_from_camera,
                                            const std::vector<int>& tracks, const SearchGate& gate,
                                            const MatchOptions& options) {
  if (observed.x.empty()) return {};
  const PointGrid grid(observed.x, gate.radius);
  const Projector projector(world_from_camera);

  std::vector<Candidate> candidates;
  std::vector<int> near;
  for (int track : tracks) {
    Eigen::Vector2d predicted;
    if (!projector(map.position(track), predicted)) continue;
    near.clear();
    grid.near(predicted, gate.radius, near);
    if (near.empty()) continue;
    if (gate.pose_covariance) keep_likely(map, observed, projector, track, gate, near);
    const Sight& latest = map.track(track).sights.back();
    Candidate candidate;
    candidate.track = track;
    if (best_keypoint(observed, map.keyframe(latest.keyframe).observed(), latest.keypoint, near,
                      options, candidate))
      candidates.push_back(candidate);
  }

  // The better fit takes a contested keypoint.
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.track < b.track;
  });
  std::vector<bool> taken(observed.size(), false);
  std::vector<LandmarkSight> sights;
  for (const Candidate& candidate : candidates) {
    if (taken[candidate.keypoint]) continue;
    taken[candidate.keypoint] = true;
    sights.push_back({candidate.track, candidate.keypoint});
  }
  std::sort(sights.begin(), sights.end(),
            [](const LandmarkSight& a, const LandmarkSight& b) { return a.track < b.track; });
  return sights;
}

}  // namespace eifmap
