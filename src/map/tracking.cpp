#include "map/tracking.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "geometry/projection.h"
#include "map/guided_search.h"

namespace eifmap {
namespace {

// How many keyframes around the reference make the local map.
constexpr int kLocalKeyframes = 12;

// The landmark's own uncertainty, as it shows from the pose, is a part of the measurement's sigma:
// a young landmark may be off by pixels along its ray and still be right.
std::vector<MapObservation> map_observations(const Map& map, const ObservedFrame& observed,
                                             const Rigid3& world_from_camera,
                                             const std::vector<LandmarkSight>& sights) {
  const Projector projector(world_from_camera);
  std::vector<MapObservation> observations;
  observations.reserve(sights.size());
  for (const LandmarkSight& sight : sights) {
    const double sigma = observed.sigma[sight.keypoint];
    MapObservation observation{map.position(sight.track), observed.x[sight.keypoint], sigma};
    Eigen::Vector2d x;
    Eigen::Matrix<double, 2, 3> d_point;
    if (projector(observation.point, x, nullptr, &d_point)) {
      const Eigen::Matrix2d shown =
          d_point * map.position_covariance(sight.track) * d_point.transpose();
      observation.sigma = std::sqrt(sigma * sigma + shown.trace());
    }
    observations.push_back(observation);
  }
  return observations;
}

// [WD10] Algorithm 1, step 4: matches of Omega_m whose keypoint in the keyframe is a landmark.
std::vector<LandmarkSight> landmarks_among(const Map& map, int keyframe,
                                           const std::vector<Match>& matches) {
  std::vector<LandmarkSight> sights;
  for (const Match& match : matches) {
    const int track = map.keyframe(keyframe).track[match.a];
    if (track != kNoTrack && map.track(track).is_landmark()) sights.push_back({track, match.b});
  }
  std::sort(sights.begin(), sights.end(),
            [](const LandmarkSight& a, const LandmarkSight& b) { return a.track < b.track; });
  return sights;
}

// [WD10] Algorithm 1, step 3: the guess along the relative pose's direction, as far as the last
// frame was. Never at P_i itself, where the fit is singular.
Rigid3 guess_along_line(const Map& map, int reference, const RelativePose& relative,
                        const Rigid3& last) {
  const Rigid3& world_from_i = map.pose(reference);
  const double shortest = 0.02 * map.median_depth(reference);
  const double length = std::max((last.translation - world_from_i.translation).norm(), shortest);
  return world_from_i * Rigid3(relative.i_from_j, length * relative.direction);
}

// All local landmarks are looked for around the pose, and the pose is refined on what is found.
void refine_on_local_map(const Map& map, const ObservedFrame& observed,
                         const MapperOptions& options, Tracking& tracking) {
  const std::vector<int> local =
      map.landmarks_of(map.covisible(tracking.reference, kLocalKeyframes));
  const double radius = options.landmark.search_radius_px * map.radians_per_pixel();
  const std::vector<LandmarkSight> found =
      search_landmarks(map, observed, tracking.world_from_camera, local, radius, options.match);
  const AbsolutePose refined = refine_absolute_pose(
      tracking.world_from_camera,
      map_observations(map, observed, tracking.world_from_camera, found), options.absolute_pose);
  tracking.num_matches = static_cast<int>(found.size());
  tracking.sights.clear();
  for (std::size_t k = 0; k < found.size(); ++k)
    if (refined.inlier.size() == found.size() && refined.inlier[k])
      tracking.sights.push_back(found[k]);
  tracking.reason = refined.reason;
  tracking.world_from_camera = refined.world_from_camera;
  tracking.covariance = refined.covariance;
  const int wanted = std::max(
      options.absolute_pose.min_inliers,
      static_cast<int>(options.tracking.min_inlier_ratio * static_cast<double>(found.size())));
  if (!refined.ok() || refined.num_inliers < wanted) {
    tracking.reason = Reason::kTooFewInliers;
    std::ostringstream detail;
    detail << refined.num_inliers << " of " << found.size() << " map features agree, wanted "
           << wanted;
    tracking.detail = detail.str();
  }
}

// A pose from the matches at hand becomes one of the whole local map, or is given up.
bool confirm(const Map& map, const ObservedFrame& observed, const Rigid3& pose, PoseSource source,
             const MapperOptions& options, Tracking& tracking) {
  tracking.world_from_camera = pose;
  tracking.source = source;
  refine_on_local_map(map, observed, options, tracking);
  return tracking.ok();
}

bool try_pose(const Map& map, const ObservedFrame& observed, const Rigid3& guess,
              const std::vector<LandmarkSight>& sights, PoseSource source,
              const MapperOptions& options, Tracking& tracking) {
  const AbsolutePose pose = refine_absolute_pose(
      guess, map_observations(map, observed, guess, sights), options.absolute_pose);
  return pose.ok() && confirm(map, observed, pose.world_from_camera, source, options, tracking);
}

bool try_scale_fit(const Map& map, const ObservedFrame& observed, const Rigid3& last,
                   const std::vector<LandmarkSight>& sights, const MapperOptions& options,
                   Tracking& tracking) {
  if (static_cast<int>(sights.size()) < options.scale_fit.min_inliers) return false;
  const Rigid3 guess = guess_along_line(map, tracking.reference, tracking.relative.pose, last);
  if (guess.translation == map.pose(tracking.reference).translation) return false;  // no line
  const ScaleFit fit = fit_scale(map.pose(tracking.reference).translation, guess,
                                 map_observations(map, observed, guess, sights), options.scale_fit);
  if (!fit.ok()) return false;
  return try_pose(map, observed, fit.world_from_j, sights, PoseSource::kScaleFit, options,
                  tracking);
}

// Too little baseline for a direction: the rotation is good, the place is the last one.
bool try_map_alone(const Map& map, const ObservedFrame& observed, const Rigid3& last,
                   const std::vector<LandmarkSight>& sights, const MapperOptions& options,
                   Tracking& tracking) {
  const Rigid3 guess(
      (map.pose(tracking.reference).rotation * tracking.relative.rotation.i_from_j).normalized(),
      last.translation);
  return try_pose(map, observed, guess, sights, PoseSource::kMapOnly, options, tracking);
}

bool try_pnp(const Map& map, const ObservedFrame& observed,
             const std::vector<LandmarkSight>& sights, PoseSource source,
             const MapperOptions& options, Tracking& tracking) {
  const AbsolutePose pose =
      solve_pnp(map_observations(map, observed, map.pose(tracking.reference), sights),
                map.radians_per_pixel(), options.absolute_pose);
  // These matches were made without a guess, so that they can speak against it.
  if (!pose.ok() ||
      pose.num_inliers < options.tracking.min_inlier_ratio * static_cast<double>(sights.size()))
    return false;
  return confirm(map, observed, pose.world_from_camera, source, options, tracking);
}

// [WD10] Algorithm 1 against one keyframe, then what is left to try with its matches.
bool track_against(const Map& map, const ObservedFrame& observed, int reference, const Rigid3& last,
                   const MapperOptions& options, Tracking& tracking) {
  tracking = Tracking{};
  tracking.reference = reference;
  const ObservedFrame& keyframe = map.keyframe(reference).observed;
  tracking.matches_p = match(keyframe.omega_p, observed.omega_p, options.match);
  tracking.matches_m = match(keyframe.omega_m, observed.omega_m, options.match);
  tracking.relative = estimate_relative_pose(
      correspondences(keyframe, observed, tracking.matches_p, tracking.matches_m),
      map.radians_per_pixel(), options.relative_pose);
  const std::vector<LandmarkSight> sights = landmarks_among(map, reference, tracking.matches_m);
  if (tracking.relative.ok() && try_scale_fit(map, observed, last, sights, options, tracking))
    return true;
  if (tracking.relative.reason != Reason::kTooFewMatches &&
      try_map_alone(map, observed, last, sights, options, tracking))
    return true;
  if (try_pnp(map, observed, sights, PoseSource::kPnp, options, tracking)) return true;

  tracking.source = PoseSource::kNone;
  tracking.reason = tracking.relative.reason == Reason::kTooFewMatches ? Reason::kTooFewMatches
                                                                       : Reason::kTooFewInliers;
  std::ostringstream detail;
  detail << tracking.matches_p.size() + tracking.matches_m.size() << " matches with keyframe "
         << reference << ", " << sights.size() << " of them map features";
  tracking.detail = detail.str();
  return false;
}

}  // namespace

std::vector<Correspondence> correspondences(const ObservedFrame& i, const ObservedFrame& j,
                                            const std::vector<Match>& p,
                                            const std::vector<Match>& m) {
  std::vector<Correspondence> all;
  all.reserve(p.size() + m.size());
  for (const auto* group : {&p, &m})
    for (const Match& match : *group)
      all.push_back({i.x[match.a], j.x[match.b], i.sigma[match.a], j.sigma[match.b]});
  return all;
}

Tracking track_frame(const Map& map, const ObservedFrame& observed, int reference,
                     const Rigid3& last, const MapperOptions& options) {
  Tracking tracking;
  if (track_against(map, observed, reference, last, options, tracking)) return tracking;
  // Another view of the same place may match where this one does not.
  constexpr int kOthers = 3;
  std::vector<int> others = map.covisible(reference, kOthers);
  others.push_back(map.num_keyframes() - 1);
  for (int other : others) {
    Tracking retry;
    if (other != reference && track_against(map, observed, other, last, options, retry))
      return retry;
  }
  return tracking;
}

Tracking relocalize(const Map& map, const ObservedFrame& observed,
                    const std::vector<int>& keyframes, const MapperOptions& options) {
  Tracking tracking;
  for (int k : keyframes) {
    tracking = Tracking{};
    tracking.reference = k;
    const std::vector<LandmarkSight> sights = landmarks_among(
        map, k, match(map.keyframe(k).observed.omega_m, observed.omega_m, options.match));
    if (static_cast<int>(sights.size()) < options.absolute_pose.min_inliers) continue;
    if (!try_pnp(map, observed, sights, PoseSource::kRelocalized, options, tracking)) continue;
    if (static_cast<int>(tracking.sights.size()) >= options.lost.min_inliers) return tracking;
  }
  tracking.reason = Reason::kNotRelocalized;
  tracking.source = PoseSource::kNone;
  tracking.sights.clear();
  std::ostringstream detail;
  detail << "none of " << keyframes.size() << " keyframes tried has " << options.lost.min_inliers
         << " map features that agree";
  tracking.detail = detail.str();
  return tracking;
}

}  // namespace eifmap
