#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/projection.h"
#include "geometry/triangulation.h"
#include "map/epipolar_match.h"
#include "map/keyframe_insertion.h"

namespace eifmap {
namespace {

constexpr double kDegree = M_PI / 180;

// The keyframe's features that may belong to the map: Omega_m, and what is left of Omega_p if asked
// for.
std::vector<int> map_features(const Keyframe& keyframe, bool with_omega_p) {
  std::vector<int> features;
  for (int keypoint = 0; keypoint < keyframe.observed().size(); ++keypoint)
    if (keyframe.observed().in_omega_m(keypoint) || (with_omega_p && !keyframe.spent[keypoint]))
      features.push_back(keypoint);
  return features;
}

// Of them, those that no landmark explains yet.
std::vector<int> open_features(const Keyframe& keyframe, bool with_omega_p, const Map& map) {
  std::vector<int> open = map_features(keyframe, with_omega_p);
  std::erase_if(open, [&](int keypoint) {
    const int track = keyframe.track[keypoint];
    return track != kNoTrack && map.track(track).is_landmark();
  });
  return open;
}

std::vector<Sighting> sightings_of(const Map& map, const std::vector<Sight>& sights) {
  std::vector<Sighting> sightings;
  for (const Sight& s : sights) {
    const ObservedFrame& observed = map.keyframe(s.keyframe).observed();
    sightings.push_back({map.pose(s.keyframe), observed.x[s.keypoint], observed.sigma[s.keypoint]});
  }
  return sightings;
}

double error_of(const Sighting& sighting, const Eigen::Vector3d& point) {
  Eigen::Vector2d x;
  if (!project(sighting.world_from_camera, point, x))
    return std::numeric_limits<double>::infinity();
  return (sighting.x - x).norm() / sighting.sigma;
}

// The sights that agree with the point of the best pair of them: one wrong match must not keep the
// others from becoming a landmark.
std::vector<bool> largest_agreement(const std::vector<Sighting>& sightings, double max_error) {
  std::vector<bool> best;
  std::ptrdiff_t best_count = 0;
  for (std::size_t a = 0; a < sightings.size(); ++a)
    for (std::size_t b = a + 1; b < sightings.size(); ++b) {
      const Sighting pair[] = {sightings[a], sightings[b]};
      const TriangulatedPoint point = triangulate(pair);
      if (!point.valid || point.max_error > max_error) continue;
      std::vector<bool> agrees;
      for (const Sighting& s : sightings) agrees.push_back(error_of(s, point.point) < max_error);
      const auto count = std::count(agrees.begin(), agrees.end(), true);
      if (count > best_count) best_count = count, best = std::move(agrees);
    }
  return best;
}

// The point of a candidate; takes out the sights that disagree with the largest agreement of three
// or more.
TriangulatedPoint triangulate_track(Map& map, int track, const LandmarkOptions& options) {
  const std::vector<Sight> sights = map.track(track).sights;
  const std::vector<Sighting> sightings = sightings_of(map, sights);
  const TriangulatedPoint point = triangulate(sightings);
  if (sights.size() < 3 || (point.valid && point.max_error < options.max_error)) return point;
  const std::vector<bool> agrees = largest_agreement(sightings, options.max_error);
  if (std::count(agrees.begin(), agrees.end(), true) < 3) return point;
  for (std::size_t k = 0; k < sights.size(); ++k)
    if (!agrees[k]) map.remove_sight(track, sights[k].keyframe);
  return triangulate(sightings_of(map, map.track(track).sights));
}

// A keypoint that a known landmark fits joins it, and leaves the candidate it was in.
void join_landmark(Map& map, int track, const Sight& sight, const LandmarkOptions& options) {
  const ObservedFrame& observed = map.keyframe(sight.keyframe).observed();
  PointMeasurement measurement;
  measurement.pose = sight.keyframe;
  measurement.x = observed.x[sight.keypoint];
  measurement.sigma = observed.sigma[sight.keypoint];
  if (map.filter().error(map.track(track).landmark, measurement) > options.max_error) return;
  const int candidate = map.keyframe(sight.keyframe).track[sight.keypoint];
  if (candidate != kNoTrack) map.remove_sight(candidate, sight.keyframe);
  map.add_sight(track, sight);
}

// One match of the new keyframe with a neighbour. `touched` collects the candidates that grew.
void take_match(Map& map, const Sight& fresh, const Sight& old, const LandmarkOptions& options,
                std::vector<int>& touched) {
  const int fresh_track = map.keyframe(fresh.keyframe).track[fresh.keypoint];
  const int old_track = map.keyframe(old.keyframe).track[old.keypoint];
  if (old_track != kNoTrack && map.track(old_track).is_landmark())
    return join_landmark(map, old_track, fresh, options);
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

bool good_enough(const Track& track, const TriangulatedPoint& point,
                 const LandmarkOptions& options) {
  return point.valid && static_cast<int>(track.sights.size()) >= options.min_views &&
         point.max_parallax > options.min_parallax_deg * kDegree &&
         point.max_error < options.max_error &&
         point.relative_depth_sigma < options.max_relative_depth;
}

}  // namespace

int extend_tracks(Map& map, int keyframe, const MapperOptions& options,
                  const TrackExtension& extension) {
  std::vector<int> neighbours = map.covisible(keyframe, 1 + options.landmark.neighbours);
  neighbours.erase(neighbours.begin());
  // Shorter, the pose's own error would make the depths.
  const double shortest = std::max(0.02 * map.median_depth(keyframe),
                                   options.landmark.min_baseline_sigma * extension.sigma_centre);
  const EpipolarMatchOptions along{options.landmark.max_error, options.match.max_ratio,
                                   options.match.max_distance};
  std::vector<int> touched;
  for (int k : neighbours) {
    const double baseline = (map.pose(k).translation - map.pose(keyframe).translation).norm();
    if (!(baseline > shortest)) continue;
    const Keyframe &old = map.keyframe(k), &fresh = map.keyframe(keyframe);
    const std::vector<Match> matches = match_along_epipolar_lines(
        old.observed(), map_features(old, extension.with_omega_p), fresh.observed(),
        open_features(fresh, extension.with_omega_p, map), map.pose(k), map.pose(keyframe), along);
    for (const Match& m : matches)
      take_match(map, {keyframe, m.b}, {k, m.a}, options.landmark, touched);
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  LandmarkOptions wanted = options.landmark;
  if (extension.few_tracked) wanted.min_views = std::min(wanted.min_views, wanted.min_views_if_few);
  int promoted = 0;
  for (int track : touched) {
    const TriangulatedPoint point = triangulate_track(map, track, options.landmark);
    if (!good_enough(map.track(track), point, wanted)) continue;
    map.promote(track, point.point, point.covariance);
    ++promoted;
  }
  return promoted;
}

}  // namespace eifmap
