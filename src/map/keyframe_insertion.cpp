#include "map/keyframe_insertion.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "geometry/robust.h"
#include "map/map_bounds.h"
#include "map/near_keyframes.h"
#include "map/redundancy.h"

namespace eifmap {
namespace {

// An edge with the reference, whose relative pose is at hand; where that is too near for a certain
// direction, with the neighbour that is seen from furthest.
bool add_relative_pose(Map& map, int keyframe, const Tracking& tracking,
                       const MapperOptions& options) {
  // Where a plane fills the view, the two-view direction may be the plane's other solution.
  // Nor is it one to believe where the map confirms no pose along it.
  const FramePair& pair = tracking.pair;
  if (tracking.source == PoseSource::kScaleFit && !pair.relative.planar &&
      add_edge(map, tracking.related, keyframe, pair.explained_p(), pair.relative.pose, options))
    return true;
  std::vector<int> neighbours = map.covisible(keyframe, 1 + options.edge.neighbours);
  neighbours.erase(neighbours.begin());
  const auto distance = [&](int k) {
    return (map.pose(k).translation - map.pose(keyframe).translation).norm();
  };
  std::stable_sort(neighbours.begin(), neighbours.end(),
                   [&](int a, int b) { return distance(a) > distance(b); });
  return std::any_of(neighbours.begin(), neighbours.end(), [&](int k) {
    return distance(k) > 0 && add_edge_from_map(map, k, keyframe, options);
  });
}

// Of the edge added last.
void add_innovation(const Map& map, const std::optional<FrameError>& error, NisSum& sum) {
  if (!error) return;
  const InformationFilter& filter = map.filter();
  const std::optional<double> squared =
      squared_innovation(map, filter.edges().back(), *error, filter.edge_variance());
  if (!squared) return;
  const bool within = *squared < kEdgeNisGate * kEdgeNisGate;
  ++(within ? sum.count : sum.beyond);
  if (within) sum.squared += *squared;
}

// Information is lost by it, consistency is not.
void cull(Map& map, int newest, const std::vector<int>& hardly_seen) {
  constexpr int kCandidateAge = 8;  // keyframes without news: it will not become a landmark
  constexpr int kLandmarkAge = 3;   // by then a landmark has its third view
  const std::vector<int> measured = map.measured_tracks();
  const auto is_measured = [&measured](int t) {
    return std::binary_search(measured.begin(), measured.end(), t);
  };
  for (int t = 0; t < map.num_tracks(); ++t) {
    const Track& track = map.track(t);
    if (track.sights.empty()) continue;
    const int age = newest - track.sights.back().keyframe;
    const bool stale_candidate = !track.is_landmark() && age > kCandidateAge;
    const bool weak_landmark = track.is_landmark() && age > kLandmarkAge && track.sights.size() < 3;
    if (stale_candidate || (weak_landmark && !is_measured(t))) map.remove_track(t);
  }
  for (const int t : hardly_seen)
    if (!is_measured(t)) map.remove_track(t);
}

double sigma_centre(const Tracking& tracking) {
  const Eigen::Matrix3d centre = tracking.covariance.bottomRightCorner<3, 3>();
  return std::sqrt(std::max(
      0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centre).eigenvalues().maxCoeff()));
}

// From the pose to those of the sights' features that still are landmarks.
double median_sight_depth(const Map& map, const Rigid3& world_from_camera,
                          const std::vector<LandmarkSight>& sights) {
  std::vector<double> depths;
  const Rigid3 camera_from_world = world_from_camera.inverse();
  for (const LandmarkSight& sight : sights)
    if (map.track(sight.track).is_landmark())
      depths.push_back((camera_from_world * map.position(sight.track)).z());
  return take_median(depths);
}

// Of the camera from the reference, or a nearer keyframe that sees much of what the frame sees: on
// a way back the reference is not the nearest. The newest keyframes do not count: of a camera that
// wavers too few would come, and one run of four bridged a gap in a recording with twice the error.
double shortest_baseline(const Map& map, const Tracking& tracking, const KeyframeOptions& options) {
  const std::vector<int> seen = num_seen(map, tracking.sights);
  const double enough = options.near_share * static_cast<double>(tracking.sights.size());
  const auto baseline = [&](int k) {
    return (tracking.world_from_camera.translation - map.pose(k).translation).norm();
  };
  double shortest = baseline(tracking.reference);
  for (int k = 0; k < map.num_keyframes() - options.keep_newest; ++k)
    if (seen[k] > 0 && seen[k] >= enough) shortest = std::min(shortest, baseline(k));
  return shortest;
}

// What the filter made of the new keyframe against what tracking had measured. The one silent
// catastrophe of monocular mapping is a map whose scale jumps: then the filter moves the keyframe
// far along its baseline, moves what it was tracked by nearer or further as a whole, or throws out
// most of it. `before`: as of before the update.
struct Before {
  Rigid3 reference;
  double depth = 0;  // median, of the sights
};
Reason judge_update(const Map& map, int keyframe, const Tracking& tracking, const Before& before,
                    const FilterUpdate& update) {
  if (update.reason != Reason::kNone) return update.reason;
  constexpr double kJump = 1.5, kShortBaseline = 0.02;  // the latter relative to the depth
  const auto dropped = std::count_if(update.dropped.begin(), update.dropped.end(),
                                     [keyframe](const auto& d) { return d.pose == keyframe; });
  if (2 * dropped > static_cast<std::ptrdiff_t>(tracking.sights.size())) return Reason::kScaleJump;
  const auto jumped = [](double a, double b) { return a > kJump * b || b > kJump * a; };
  if (jumped(median_sight_depth(map, map.pose(keyframe), tracking.sights), before.depth))
    return Reason::kScaleJump;
  const double expected =
      (tracking.world_from_camera.translation - before.reference.translation).norm();
  const double baseline =
      (map.pose(keyframe).translation - map.pose(tracking.reference).translation).norm();
  if (std::max(expected, baseline) < kShortBaseline * map.median_depth(keyframe))
    return Reason::kNone;
  return jumped(expected, baseline) ? Reason::kScaleJump : Reason::kNone;
}

// Not one that the newest keyframe is tied to by an edge, of which the innovation has just been
// seen.
void remove_redundant(Map& map, int newest, const Tracking& tracking,
                      const KeyframeOptions& options) {
  const auto redundant = redundant_keyframe(map, tracking.reference, options);
  if (!redundant) return;
  const FilterEdges& edges = map.filter().edges();
  const bool is_tied = std::any_of(edges.begin(), edges.end(), [&](const FilterEdge& edge) {
    return edge.i == *redundant && edge.j == newest;
  });
  if (!is_tied) map.remove_keyframe(*redundant);
}

}  // namespace

bool wants_keyframe(const Map& map, const Tracking& tracking, const Usual& usual,
                    const MapperOptions& options) {
  const int inliers = static_cast<int>(tracking.sights.size());
  if (inliers < options.keyframe.min_inliers || usual.odd_step) return false;
  const Rigid3& reference = map.pose(tracking.reference);
  const double baseline = (tracking.world_from_camera.translation - reference.translation).norm();
  const double depth = median_sight_depth(map, tracking.world_from_camera, tracking.sights);
  if (sigma_centre(tracking) > std::max(0.1 * baseline, 0.01 * depth)) return false;
  const double haste = inliers < options.keyframe.few_tracked ? 0.5 : 1;
  const double far = haste * options.keyframe.max_baseline_ratio * depth;
  const bool is_near = options.tracking.near_keyframes > 0 &&
                       shortest_baseline(map, tracking, options.keyframe) <= far;
  if (baseline > far && !is_near) return true;
  return inliers < options.keyframe.min_tracked_ratio * usual.most_tracked;
}

Insertion insert_keyframe(Map& map, std::shared_ptr<const ObservedFrame> observed,
                          const Tracking& tracking, const std::vector<int>& hardly_seen,
                          const MapperOptions& options) {
  const Before before{map.pose(tracking.reference),
                      median_sight_depth(map, tracking.world_from_camera, tracking.sights)};
  Insertion insertion;
  NisSum& edges = insertion.innovations.edges;
  insertion.innovations.sights = innovations_of_sights(map, *observed, tracking);
  std::optional<FrameError> error(std::in_place);
  if (!options.edge.enabled ||
      !frame_error(map, *observed, tracking, options.absolute_pose, *error))
    error.reset();
  insertion.removed_keyframes = make_room(map, tracking.reference, options.bound);
  insertion.removed_landmarks = drop_landmarks(map, tracking.reference, options.bound);
  const bool no_keyframe_more =
      options.bound.max_keyframes > 0 && map.num_keyframes_in_use() >= options.bound.max_keyframes;
  if (no_keyframe_more || is_crowded(map, options.bound)) {
    insertion.reason = Reason::kMapFull;
    return insertion;
  }
  const int k = map.add_keyframe(std::move(observed), tracking.world_from_camera);
  for (const LandmarkSight& sight : tracking.sights)  // but those that had to make room
    if (map.track(sight.track).is_landmark()) map.add_sight(sight.track, {k, sight.keypoint});
  const bool has_edge = options.edge.enabled && add_relative_pose(map, k, tracking, options);
  if (has_edge) add_innovation(map, error, edges);
  extend_tracks(map, k, options,
                {sigma_centre(tracking),
                 static_cast<int>(tracking.sights.size()) < options.landmark.few_tracked,
                 options.landmark.promote_omega_p && !has_edge});
  remove_redundant(map, k, tracking, options.keyframe);
  const FilterUpdate update = map.update();
  insertion.keyframe = k;
  insertion.reason = judge_update(map, k, tracking, before, update);
  cull(map, k, hardly_seen);
  insertion.removed_landmarks += drop_landmarks(map, k, options.bound);
  return insertion;
}

}  // namespace eifmap
