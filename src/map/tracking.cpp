#include "map/tracking.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "geometry/projection.h"
#include "map/guided_search.h"
#include "motion/triangulated_scale.h"

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

// [WD10] Algorithm 1, step 4: matches whose keypoint in the keyframe is a landmark.
std::vector<LandmarkSight> landmarks_among(const Map& map, int keyframe,
                                           const std::vector<Match>& matches_m,
                                           const std::vector<Match>& matches_p = {}) {
  std::vector<LandmarkSight> sights;
  for (const auto* matches : {&matches_m, &matches_p})
    for (const Match& match : *matches) {
      const int track = map.keyframe(keyframe).track[match.a];
      if (track != kNoTrack && map.track(track).is_landmark()) sights.push_back({track, match.b});
    }
  std::sort(sights.begin(), sights.end(),
            [](const LandmarkSight& a, const LandmarkSight& b) { return a.track < b.track; });
  return sights;
}

// [WD10] Algorithm 1, step 3: the guess along the relative pose's direction, as far as the same
// speed takes the camera. Never at P_i itself, where the fit is singular.
Rigid3 guess_along_line(const Map& map, int related, const RelativePose& relative,
                        const LastMotion& last) {
  const Rigid3& world_from_i = map.pose(related);
  const double shortest = 0.02 * map.median_depth(related);
  const Eigen::Vector3d expected = last.pose.translation + last.step;
  const double length = std::max((expected - world_from_i.translation).norm(), shortest);
  return world_from_i * Rigid3(relative.i_from_j, length * relative.direction);
}

// One pose to start from, with its observations of landmarks.
class Attempt {
 public:
  Attempt(const Map& map, const ObservedFrame& observed, const MapperOptions& options,
          Tracking& tracking)
      : map_(map), observed_(observed), options_(options), tracking_(tracking) {}

  // From a start near the truth, refined on the sights at hand unless that is switched off.
  bool from(const Rigid3& start, const std::vector<LandmarkSight>& sights, PoseSource source) {
    if (!options_.tracking.refine) return confirm(start, source);
    const AbsolutePose pose = refine_absolute_pose(
        start, map_observations(map_, observed_, start, sights), options_.absolute_pose);
    return pose.ok() && confirm(pose.world_from_camera, source);
  }

  // A pose from the matches at hand becomes one of the whole local map, or is given up.
  bool confirm(const Rigid3& pose, PoseSource source) {
    tracking_.world_from_camera = pose;
    tracking_.source = source;
    const std::vector<int> local =
        map_.landmarks_of(map_.covisible(tracking_.reference, kLocalKeyframes));
    const double radius = options_.landmark.search_radius_px * map_.radians_per_pixel();
    const std::vector<LandmarkSight> found =
        search_landmarks(map_, observed_, pose, local, radius, options_.match);
    const std::vector<MapObservation> observations = map_observations(map_, observed_, pose, found);
    const AbsolutePose judged =
        options_.tracking.refine ? refine_absolute_pose(pose, observations, options_.absolute_pose)
                                 : judge_absolute_pose(pose, observations, options_.absolute_pose);
    take(judged, found);
    return tracking_.ok();
  }

 private:
  void take(const AbsolutePose& judged, const std::vector<LandmarkSight>& found) {
    tracking_.num_matches = static_cast<int>(found.size());
    tracking_.sights.clear();
    for (std::size_t k = 0; k < found.size(); ++k)
      if (judged.inlier.size() == found.size() && judged.inlier[k])
        tracking_.sights.push_back(found[k]);
    tracking_.reason = judged.reason;
    tracking_.world_from_camera = judged.world_from_camera;
    tracking_.covariance = judged.covariance;
    const int wanted = std::max(
        options_.absolute_pose.min_inliers,
        static_cast<int>(options_.tracking.min_inlier_ratio * static_cast<double>(found.size())));
    if (judged.ok() && judged.num_inliers >= wanted) return;
    tracking_.reason = Reason::kTooFewInliers;
    std::ostringstream detail;
    detail << judged.num_inliers << " of " << found.size() << " map features agree, wanted "
           << wanted;
    tracking_.detail = detail.str();
  }

  const Map& map_;
  const ObservedFrame& observed_;
  const MapperOptions& options_;
  Tracking& tracking_;
};

// The sixth degree of freedom of a relative pose, by the chosen way.
std::optional<Rigid3> place_along_line(const Map& map, const ObservedFrame& observed,
                                       const RelativePose& relative, const LastMotion& last,
                                       const std::vector<LandmarkSight>& sights,
                                       const MapperOptions& options, const Tracking& tracking) {
  const Rigid3 guess = guess_along_line(map, tracking.related, relative, last);
  const Eigen::Vector3d& centre_i = map.pose(tracking.related).translation;
  if (guess.translation == centre_i) return std::nullopt;  // no line
  if (options.tracking.start == PoseStart::kSameSpeed) return guess;
  if (static_cast<int>(sights.size()) < options.scale_fit.min_inliers) return std::nullopt;
  if (options.tracking.start == PoseStart::kTriangulation) {
    const ObservedFrame& keyframe = map.keyframe(tracking.related).observed;
    std::vector<DepthRatio> pairs;
    for (const LandmarkSight& sight : sights)
      for (const Sight& s : map.track(sight.track).sights)
        if (s.keyframe == tracking.related)
          pairs.push_back(
              {map.position(sight.track), keyframe.x[s.keypoint], observed.x[sight.keypoint]});
    return place_by_triangulation(map.pose(tracking.related), relative, pairs);
  }
  const ScaleFit fit =
      fit_scale(centre_i, guess, map_observations(map, observed, guess, sights), options.scale_fit);
  if (!fit.ok()) return std::nullopt;
  return fit.world_from_j;
}

// Matches with one keyframe and what they say of the frame's pose relative to it.
void relate(const Map& map, const ObservedFrame& observed, int related,
            const MapperOptions& options, Tracking& tracking) {
  tracking.related = related;
  const ObservedFrame& keyframe = map.keyframe(related).observed;
  tracking.matches_p = match_omega_p(keyframe, observed, options.match);
  tracking.matches_m = match_omega_m(keyframe, observed, options.match);
  tracking.relative = estimate_relative_pose(
      correspondences(keyframe, observed, tracking.matches_p, tracking.matches_m),
      map.radians_per_pixel(), options.relative_pose);
}

bool try_one_relative_pose(const Map& map, const ObservedFrame& observed, const LastMotion& last,
                           const std::vector<LandmarkSight>& sights, const MapperOptions& options,
                           Tracking& tracking) {
  const std::optional<Rigid3> start =
      place_along_line(map, observed, tracking.relative.pose, last, sights, options, tracking);
  return start &&
         Attempt(map, observed, options, tracking).from(*start, sights, PoseSource::kScaleFit);
}

// Where a plane fills the view two motions explain the matches: that with which more of the map
// agrees is the camera's.
bool try_relative_pose(const Map& map, const ObservedFrame& observed, const LastMotion& last,
                       const std::vector<LandmarkSight>& sights, const MapperOptions& options,
                       Tracking& tracking) {
  if (!tracking.relative.ok() || options.tracking.start == PoseStart::kPnp) return false;
  const std::vector<RelativePoseAlternative> alternatives = tracking.relative.alternatives;
  bool found = try_one_relative_pose(map, observed, last, sights, options, tracking);
  for (const RelativePoseAlternative& alternative : alternatives) {
    Tracking other = tracking;
    other.relative.pose = alternative.pose;
    other.relative.inlier = alternative.inlier;
    other.relative.num_inliers = alternative.num_inliers;
    if (!try_one_relative_pose(map, observed, last, sights, options, other)) continue;
    if (found && other.sights.size() <= tracking.sights.size()) continue;
    tracking = std::move(other);
    found = true;
  }
  return found;
}

// The reference is too near for a direction. Of the keyframes that share its landmarks, the first
// one from which the camera has moved far enough.
bool try_older_reference(const Map& map, const ObservedFrame& observed, const LastMotion& last,
                         const MapperOptions& options, Tracking& tracking) {
  constexpr int kTried = 8;
  const double far_enough =
      options.keyframe.max_baseline_ratio * map.median_depth(tracking.reference);
  for (int k : map.covisible(tracking.reference, kTried)) {
    if ((map.pose(k).translation - last.pose.translation).norm() < far_enough) continue;
    Tracking older;
    older.reference = tracking.reference;
    relate(map, observed, k, options, older);
    const std::vector<LandmarkSight> sights =
        landmarks_among(map, k, older.matches_m, older.matches_p);
    if (!try_relative_pose(map, observed, last, sights, options, older)) return false;
    tracking = std::move(older);
    return true;
  }
  return false;
}

// Too little baseline for a direction: the rotation is good, the place is the last one.
bool try_map_alone(const Map& map, const ObservedFrame& observed, const LastMotion& last,
                   const std::vector<LandmarkSight>& sights, const MapperOptions& options,
                   Tracking& tracking) {
  const Rigid3 guess(
      (map.pose(tracking.related).rotation * tracking.relative.rotation.i_from_j).normalized(),
      last.pose.translation);
  return Attempt(map, observed, options, tracking).from(guess, sights, PoseSource::kMapOnly);
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
  return Attempt(map, observed, options, tracking).confirm(pose.world_from_camera, source);
}

// [WD10] Algorithm 1 against one keyframe, then what is left to try with its matches.
bool track_against(const Map& map, const ObservedFrame& observed, int reference,
                   const LastMotion& last, const MapperOptions& options, Tracking& tracking) {
  tracking = Tracking{};
  tracking.reference = reference;
  relate(map, observed, reference, options, tracking);
  const std::vector<LandmarkSight> sights =
      landmarks_among(map, reference, tracking.matches_m, tracking.matches_p);
  if (try_relative_pose(map, observed, last, sights, options, tracking)) return true;
  const bool no_baseline = tracking.relative.reason == Reason::kNoBaseline;
  if (no_baseline && options.tracking.older_reference &&
      try_older_reference(map, observed, last, options, tracking))
    return true;
  if (tracking.relative.reason != Reason::kTooFewMatches &&
      try_map_alone(map, observed, last, sights, options, tracking))
    return true;
  if ((options.tracking.fall_back_to_pnp || options.tracking.start == PoseStart::kPnp) &&
      try_pnp(map, observed, sights, PoseSource::kPnp, options, tracking))
    return true;

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
                     const LastMotion& last, const MapperOptions& options) {
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
    tracking.reference = tracking.related = k;
    const std::vector<LandmarkSight> sights =
        landmarks_among(map, k, match_omega_m(map.keyframe(k).observed, observed, options.match));
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
