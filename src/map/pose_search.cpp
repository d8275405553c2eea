#include "map/pose_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <utility>

#include "geometry/projection.h"
#include "map/guided_search.h"
#include "map/image_shift.h"
#include "map/near_keyframes.h"
#include "map/other_place.h"
#include "map/sight_counts.h"

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

}  // namespace

std::vector<LandmarkSight> landmarks_among(const Map& map, int keyframe,
                                           const std::vector<Match>& matches_m,
                                           const std::vector<Match>& matches_p) {
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

double search_radius(const Map& map, const MapperOptions& options) {
  return options.landmark.search_radius_px * map.radians_per_pixel();
}

void refuse_as_ambiguous(const Tracking& other, Tracking& tracking) {
  std::ostringstream detail;
  detail << tracking.sights.size() << " map features agree with one place, " << other.sights.size()
         << " with another";
  tracking.reason = Reason::kAmbiguousPlace;
  tracking.detail = detail.str();
  tracking.source = PoseSource::kNone;
}

void PoseSearch::take(const AbsolutePose& judged, const std::vector<LandmarkSight>& found,
                      Tracking& tracking) const {
  tracking.num_matches = static_cast<int>(found.size());
  tracking.sights.clear();
  for (std::size_t k = 0; k < found.size(); ++k)
    if (judged.inlier[k]) tracking.sights.push_back(found[k]);
  tracking.reason = judged.reason;
  tracking.world_from_camera = judged.world_from_camera;
  tracking.covariance = judged.covariance;
  const int wanted = std::max(
      options_.absolute_pose.min_inliers,
      static_cast<int>(options_.tracking.min_inlier_ratio * static_cast<double>(found.size())));
  if (judged.ok() && judged.num_inliers >= wanted) return;
  tracking.reason = Reason::kTooFewInliers;
  std::ostringstream detail;
  detail << judged.num_inliers << " of " << found.size() << " map features agree, wanted "
         << wanted;
  tracking.detail = detail.str();
}

// The pose by what of these landmarks is found around where it would see them.
bool PoseSearch::search_around(const Guess& guess, const std::vector<int>& landmarks,
                               Tracking& tracking) const {
  const Rigid3& pose = guess.world_from_camera;
  SearchGate gate;
  gate.radius = search_radius(map_, options_);
  gate.sigmas = options_.tracking.search_sigma;
  if (gate.sigmas > 0) gate.pose_covariance = guess.covariance;
  const std::vector<LandmarkSight> found =
      search_landmarks(map_, observed_, pose, landmarks, gate, options_.match);
  const std::vector<MapObservation> observations = map_observations(map_, observed_, pose, found);
  take(options_.tracking.refine ? refine_absolute_pose(pose, observations, options_.absolute_pose)
                                : judge_absolute_pose(pose, observations, options_.absolute_pose),
       found, tracking);
  return tracking.ok();
}

// Of the landmarks that should be seen from the tracked pose, the share that is.
double PoseSearch::share_found(const std::vector<int>& landmarks, const Rigid3& pose,
                               const std::vector<LandmarkSight>& sights) const {
  const std::vector<int> expected = landmarks_expected(map_, SafeView(observed_), pose, landmarks);
  const auto seen = std::count_if(expected.begin(), expected.end(),
                                  [&sights](int track) { return sees(sights, track); });
  return expected.empty() ? 0 : static_cast<double>(seen) / static_cast<double>(expected.size());
}

// From a pose that landmarks of these keyframes gave: those of keyframes near it as well, if no
// fewer sights agree then. Where the map is at odds with itself, which is what a lap's drift makes
// of its ends, some would be found all the same, and hold the ends where they are: round a block
// the NEES became 36. There less than half as many are found, of those that should be, as of what
// has been tracked, and they are not taken.
bool PoseSearch::search_wider(const Guess& guess, const std::vector<int>& keyframes,
                              const std::vector<int>& local, Tracking& tracking) const {
  if (options_.tracking.near_keyframes == 0) return false;
  const std::vector<int> near =
      near_keyframes(map_, guess.world_from_camera, map_.median_depth(tracking.reference),
                     options_.tracking.near_keyframes, keyframes);
  if (near.empty()) return false;
  std::vector<int> others, all;
  const std::vector<int> of_near = map_.landmarks_of(near);
  std::set_difference(of_near.begin(), of_near.end(), local.begin(), local.end(),
                      std::back_inserter(others));
  std::set_union(of_near.begin(), of_near.end(), local.begin(), local.end(),
                 std::back_inserter(all));
  Tracking wider = tracking;
  if (others.empty() || !search_around(guess, all, wider) ||
      wider.sights.size() < tracking.sights.size())
    return false;
  constexpr double kOfTracked = 0.5;
  const Rigid3& pose = guess.world_from_camera;
  if (share_found(others, pose, wider.sights) <
      kOfTracked * share_found(local, pose, tracking.sights))
    return false;
  tracking = std::move(wider);
  return true;
}

// A pose from the matches at hand becomes one of the whole local map, or is given up. The first
// search's start may be known to pixels only; its result is known well enough that what merely
// looks alike nearby need not be believed.
bool PoseSearch::confirm(const Guess& guess, PoseSource source, Tracking& tracking) const {
  tracking.source = source;
  const std::vector<int> keyframes = map_.covisible(tracking.reference, kLocalKeyframes);
  const std::vector<int> local = map_.landmarks_of(keyframes);
  if (!search_around(guess, local, tracking)) return false;
  tracking.looked_for = local;
  if (!options_.tracking.second_search) return true;
  const Guess better{tracking.world_from_camera, tracking.covariance};
  if (search_wider(better, keyframes, local, tracking)) return true;
  Tracking second = tracking;
  if (search_around(better, local, second)) tracking = std::move(second);
  return true;
}

// From a start near the truth, refined on the sights at hand unless that is switched off. Where
// they are too few for that, the local map has the word on the start as it is.
bool PoseSearch::from(const Rigid3& start, const std::vector<LandmarkSight>& sights,
                      PoseSource source, Tracking& tracking) const {
  if (!options_.tracking.refine) return confirm({start, {}}, source, tracking);
  const AbsolutePose pose = refine_absolute_pose(
      start, map_observations(map_, observed_, start, sights), options_.absolute_pose);
  if (!pose.ok()) return confirm({start, {}}, source, tracking);
  return confirm({pose.world_from_camera, pose.covariance}, source, tracking);
}

void PoseSearch::relate_to(int keyframe, Tracking& tracking) const {
  tracking.related = keyframe;
  tracking.pair =
      relate(map_.keyframe(keyframe).observed(), observed_, map_.radians_per_pixel(), options_);
}

// [WD10] Algorithm 1, step 3: the guess along the relative pose's direction, as far as the same
// speed takes the camera. Never at P_i itself, where the fit is singular.
Rigid3 PoseSearch::guess_along_line(const Tracking& tracking) const {
  const Rigid3& world_from_i = map_.pose(tracking.related);
  const RelativePose& relative = tracking.pair.relative.pose;
  const double shortest = 0.02 * map_.median_depth(tracking.related);
  const Eigen::Vector3d expected = last_.pose.translation + last_.step;
  const double length = std::max((expected - world_from_i.translation).norm(), shortest);
  return world_from_i * Rigid3(relative.i_from_j, length * relative.direction);
}

std::vector<SeenTwice> PoseSearch::seen_twice(const std::vector<LandmarkSight>& sights,
                                              int keyframe) const {
  const ObservedFrame& first = map_.keyframe(keyframe).observed();
  std::vector<SeenTwice> features;
  for (const LandmarkSight& sight : sights)
    for (const Sight& s : map_.track(sight.track).sights)
      if (s.keyframe == keyframe)
        features.push_back({map_.position(sight.track),
                            correspondence(first, observed_, {s.keypoint, sight.keypoint})});
  return features;
}

// The sixth degree of freedom of the relative pose, by one of the ways.
std::optional<Rigid3> PoseSearch::place_along_line(PoseStart way,
                                                   const std::vector<LandmarkSight>& sights,
                                                   const Tracking& tracking) const {
  const Rigid3 guess = guess_along_line(tracking);
  const Rigid3& world_from_i = map_.pose(tracking.related);
  if (guess.translation == world_from_i.translation) return std::nullopt;  // no line
  if (way == PoseStart::kSameSpeed) return guess;
  if (static_cast<int>(sights.size()) < options_.scale_fit.min_inliers) return std::nullopt;
  if (way == PoseStart::kTriangulation)
    return place_by_triangulation(world_from_i, tracking.pair.relative.pose,
                                  seen_twice(sights, tracking.related));
  const ScaleFit fit =
      fit_scale(world_from_i.translation, guess, map_observations(map_, observed_, guess, sights),
                options_.scale_fit);
  if (!fit.ok()) return std::nullopt;
  return fit.world_from_j;
}

// By the chosen way; where the map does not confirm it, by the others. Each fails on frames where
// another does not. All are along the one relative pose, so that an edge may be made of it: with
// none after the others, one of four runs at every 10th image of a recording ended at twice the
// error.
bool PoseSearch::along_line(const std::vector<LandmarkSight>& sights, Tracking& tracking) const {
  const auto by = [&](PoseStart way) {
    const std::optional<Rigid3> start = place_along_line(way, sights, tracking);
    return start && from(*start, sights, PoseSource::kScaleFit, tracking);
  };
  const PoseStart chosen = options_.tracking.start;
  if (by(chosen)) return true;
  if (!options_.tracking.fall_back) return false;
  for (const PoseStart way :
       {PoseStart::kScaleFit, PoseStart::kTriangulation, PoseStart::kSameSpeed})
    if (way != chosen && by(way)) return true;
  return false;
}

// Where a plane fills the view two motions explain the matches: that with which more of the map
// agrees is the camera's.
bool PoseSearch::by_relative_pose(const std::vector<LandmarkSight>& sights,
                                  Tracking& tracking) const {
  if (!tracking.pair.relative.ok() || options_.tracking.start == PoseStart::kPnp) return false;
  const std::vector<RelativePoseAlternative> alternatives = tracking.pair.relative.alternatives;
  bool found = along_line(sights, tracking);
  for (const RelativePoseAlternative& alternative : alternatives) {
    Tracking other = tracking;
    other.pair.relative.pose = alternative.pose;
    other.pair.relative.inlier = alternative.inlier;
    other.pair.relative.num_inliers = alternative.num_inliers;
    if (!along_line(sights, other)) continue;
    if (found && other.sights.size() <= tracking.sights.size()) continue;
    tracking = std::move(other);
    found = true;
  }
  return found;
}

// The reference is too near for a direction. Of the keyframes that share its landmarks, the first
// one from which the camera has moved far enough.
bool PoseSearch::against_older(Tracking& tracking) const {
  constexpr int kTried = 8;
  const double far_enough =
      options_.keyframe.max_baseline_ratio * map_.median_depth(tracking.reference);
  for (int k : map_.covisible(tracking.reference, kTried)) {
    if ((map_.pose(k).translation - last_.pose.translation).norm() < far_enough) continue;
    Tracking older;
    older.reference = tracking.reference;
    relate_to(k, older);
    if (!by_relative_pose(landmarks_among(map_, k, older.pair.m, older.pair.p), older))
      return false;
    tracking = std::move(older);
    return true;
  }
  return false;
}

// Too little baseline for a direction: the rotation is good, the place is the last one.
bool PoseSearch::by_map_alone(const std::vector<LandmarkSight>& sights, Tracking& tracking) const {
  const Eigen::Quaterniond& turn = tracking.pair.relative.rotation.i_from_j;
  const Rigid3 guess((map_.pose(tracking.related).rotation * turn).normalized(),
                     last_.pose.translation);
  return from(guess, sights, PoseSource::kMapOnly, tracking);
}

bool PoseSearch::by_pnp(const std::vector<LandmarkSight>& sights, PoseSource source,
                        Tracking& tracking) const {
  const AbsolutePose pose =
      solve_pnp(map_observations(map_, observed_, map_.pose(tracking.reference), sights),
                map_.radians_per_pixel(), options_.absolute_pose);
  // These matches were made without a guess, so that they can speak against it.
  if (!pose.ok() ||
      pose.num_inliers < options_.tracking.min_inlier_ratio * static_cast<double>(sights.size()))
    return false;
  return confirm({pose.world_from_camera, pose.covariance}, source, tracking);
}

bool PoseSearch::against(int reference, Tracking& tracking) const {
  tracking = Tracking{};
  tracking.reference = reference;
  relate_to(reference, tracking);
  const Reason without_pose = tracking.pair.relative.reason;
  const std::vector<LandmarkSight> sights =
      landmarks_among(map_, reference, tracking.pair.m, tracking.pair.p);
  if (by_relative_pose(sights, tracking)) return true;
  if (without_pose == Reason::kNoBaseline && options_.tracking.older_reference &&
      against_older(tracking))
    return true;
  if (without_pose != Reason::kTooFewMatches && by_map_alone(sights, tracking)) return true;
  if ((options_.tracking.fall_back || options_.tracking.start == PoseStart::kPnp) &&
      by_pnp(sights, PoseSource::kPnp, tracking))
    return true;

  tracking.source = PoseSource::kNone;
  tracking.reason =
      without_pose == Reason::kTooFewMatches ? Reason::kTooFewMatches : Reason::kTooFewInliers;
  std::ostringstream detail;
  detail << tracking.pair.num_matches() << " matches with keyframe " << reference << ", "
         << sights.size() << " of them map features";
  tracking.detail = detail.str();
  return false;
}

// No motion model: a step may have any length, as long as the image does not agree with the map
// from nearer by as well. Where tiles fill the view their features match one tile off as soon as
// that looks more alike, and then all of the map confirms it.
void PoseSearch::compare_with_nearer(Tracking& tracking) const {
  const Rigid3 found = tracking.world_from_camera;
  const Rigid3 same_speed(last_.pose.rotation, last_.pose.translation + last_.step);
  const Rigid3 as_turned(found.rotation, same_speed.translation);
  const auto shift = [&, sights = tracking.sights](const Rigid3& a, const Rigid3& b) {
    return median_shift(map_, sights, a, b);
  };
  const auto from_expected = [&](const Rigid3& pose) {
    return std::min(shift(pose, same_speed), shift(pose, last_.pose));
  };
  const double reach = search_radius(map_, options_);
  const double distance = from_expected(found);
  if (distance <= reach) return;
  for (const Rigid3& pose : {same_speed, last_.pose, as_turned}) {
    Tracking nearer;
    nearer.reference = tracking.reference;
    nearer.related = tracking.related;
    if (!confirm({pose, {}}, PoseSource::kMapOnly, nearer)) continue;
    if (shift(nearer.world_from_camera, found) <= reach ||
        from_expected(nearer.world_from_camera) >= distance)
      continue;
    const int far_inliers = static_cast<int>(tracking.sights.size());
    const int near_inliers = static_cast<int>(nearer.sights.size());
    const PlaceChoice choice = choose_place(far_inliers, near_inliers);
    if (choice == PlaceChoice::kFar) continue;
    if (choice == PlaceChoice::kNeither) return refuse_as_ambiguous(nearer, tracking);
    nearer.pair = std::move(tracking.pair);
    tracking = std::move(nearer);
    return;
  }
}

}  // namespace eifmap
