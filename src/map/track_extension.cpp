#include <algorithm>
#include <cmath>

#include "geometry/triangulation.h"
#include "map/keyframe_insertion.h"

namespace eifmap {
namespace {

constexpr double kDegree = M_PI / 180;

// The keyframe's features of Omega_m that no landmark explains yet.
FeatureGroup open_features(const Keyframe& keyframe, const Map& map) {
  FeatureGroup open;
  const FeatureGroup& all = keyframe.observed.omega_m;
  for (int place = 0; place < all.size(); ++place) {
    const int track = keyframe.track[all.index[place]];
    if (track != kNoTrack && map.track(track).is_landmark()) continue;
    open.index.push_back(all.index[place]);
    const auto first = all.descriptors.begin() + static_cast<std::ptrdiff_t>(place) * kDescriptorSize;
    open.descriptors.insert(open.descriptors.end(), first, first + kDescriptorSize);
  }
  return open;
}

RelativePose relative_pose(const Rigid3& world_from_i, const Rigid3& world_from_j) {
  const Rigid3 i_from_j = world_from_i.inverse() * world_from_j;
  RelativePose relative;
  relative.i_from_j = i_from_j.rotation;
  relative.direction = i_from_j.translation.normalized();
  return relative;
}

TriangulatedPoint triangulate_track(const Map& map, const Track& track) {
  std::vector<Sighting> sightings;
  for (const Sight& s : track.sights) {
    const ObservedFrame& observed = map.keyframe(s.keyframe).observed;
    sightings.push_back({map.pose(s.keyframe), observed.x[s.keypoint], observed.sigma[s.keypoint]});
  }
  return triangulate(sightings);
}

// A keypoint that a known landmark fits joins it.
bool join_landmark(Map& map, int track, const Sight& sight, const LandmarkOptions& options) {
  const ObservedFrame& observed = map.keyframe(sight.keyframe).observed;
  PointMeasurement measurement;
  measurement.pose = sight.keyframe;
  measurement.x = observed.x[sight.keypoint];
  measurement.sigma = observed.sigma[sight.keypoint];
  if (map.filter().error(map.track(track).landmark, measurement) > options.max_error) return false;
  return map.add_sight(track, sight);
}

// One match of the new keyframe with a neighbour. `touched` collects the candidates that grew.
void take_match(Map& map, const Sight& fresh, const Sight& old, const LandmarkOptions& options,
                std::vector<int>& touched) {
  const int fresh_track = map.keyframe(fresh.keyframe).track[fresh.keypoint];
  const int old_track = map.keyframe(old.keyframe).track[old.keypoint];
  if (old_track != kNoTrack && map.track(old_track).is_landmark()) {
    if (fresh_track != kNoTrack) map.remove_sight(fresh_track, fresh.keyframe);
    join_landmark(map, old_track, fresh, options);
    return;
  }
  if (fresh_track == kNoTrack && old_track == kNoTrack) {
    const int track = map.add_track(old);
    map.add_sight(track, fresh);
    touched.push_back(track);
  } else if (fresh_track == kNoTrack) {
    if (map.add_sight(old_track, fresh)) touched.push_back(old_track);
  } else if (old_track == kNoTrack) {
    if (map.add_sight(fresh_track, old)) touched.push_back(fresh_track);
  }
}

bool good_enough(const Map& map, const Track& track, const TriangulatedPoint& point,
                 const LandmarkOptions& options) {
  return point.valid && static_cast<int>(track.sights.size()) >= options.min_views &&
         point.max_parallax > options.min_parallax_deg * kDegree &&
         point.max_error < options.max_error &&
         point.relative_depth_sigma < options.max_relative_depth && map.num_keyframes() >= 2;
}

}  // namespace

int extend_tracks(Map& map, int keyframe, const MapperOptions& options) {
  std::vector<int> neighbours = map.covisible(keyframe, 1 + options.landmark.neighbours);
  neighbours.erase(neighbours.begin());
  const double depth = map.median_depth(keyframe);
  std::vector<int> touched;
  for (int k : neighbours) {
    const double baseline = (map.pose(k).translation - map.pose(keyframe).translation).norm();
    if (baseline < 0.01 * depth) continue;  // no epipolar line to check against
    const RelativePose relative = relative_pose(map.pose(k), map.pose(keyframe));
    const ObservedFrame& old_frame = map.keyframe(k).observed;
    const ObservedFrame& new_frame = map.keyframe(keyframe).observed;
    const FeatureGroup open = open_features(map.keyframe(keyframe), map);
    for (const Match& m : match(old_frame.omega_m, open, options.match)) {
      const Correspondence pair{old_frame.x[m.a], new_frame.x[m.b], old_frame.sigma[m.a],
                                new_frame.sigma[m.b]};
      if (std::abs(sampson_residual(pair, relative)) > options.landmark.max_error) continue;
      take_match(map, {keyframe, m.b}, {k, m.a}, options.landmark, touched);
    }
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  int promoted = 0;
  for (int track : touched) {
    const TriangulatedPoint point = triangulate_track(map, map.track(track));
    if (!good_enough(map, map.track(track), point, options.landmark)) continue;
    map.promote(track, point.point);
    ++promoted;
  }
  return promoted;
}

}  // namespace eifmap
