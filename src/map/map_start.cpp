#include "map/map_start.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "geometry/triangulation.h"
#include "map/frame_pair.h"
#include "map/keyframe_insertion.h"
#include "map/tracking.h"
#include "motion/absolute_pose.h"
#include "motion/relative_pose.h"

namespace eifmap {
namespace {

constexpr double kDegree = M_PI / 180;

// Merit: of which sign more features of the anchor have lasted until now and fit the pose. A small
// lead is chance.
MapSign sign_of_longer_tracks(const FramePair& pair, MapSign now) {
  const auto middle = pair.relative.inlier.begin() + static_cast<std::ptrdiff_t>(pair.p.size());
  const auto p = std::count(pair.relative.inlier.begin(), middle, 1);
  const auto m = std::count(middle, pair.relative.inlier.end(), 1);
  if (10 * p <= 11 * m) return now;
  return now == MapSign::kMinus ? MapSign::kPlus : MapSign::kMinus;
}

struct StartPoint {
  Match match;
  TriangulatedPoint point;
};

// Omega_m matches that triangulate with a certain depth; the first baseline has length 1.
std::vector<StartPoint> certain_points(const ObservedFrame& i, const ObservedFrame& j,
                                       const FramePair& pair, const MapperOptions& options) {
  const Rigid3 pose_j(pair.relative.pose.i_from_j, pair.relative.pose.direction);
  std::vector<StartPoint> points;
  for (std::size_t k = 0; k < pair.m.size(); ++k) {
    if (!pair.explains_m(k)) continue;
    const Match& m = pair.m[k];
    const Sighting sightings[] = {{Rigid3(), i.x[m.a], i.sigma[m.a]},
                                  {pose_j, j.x[m.b], j.sigma[m.b]}};
    const TriangulatedPoint point = triangulate(sightings);
    if (point.valid && point.relative_depth_sigma < options.start.max_relative_depth &&
        point.max_error < options.landmark.max_error)
      points.push_back({m, point});
  }
  return points;
}

template <typename... Parts>
std::string join(const Parts&... parts) {
  std::ostringstream text;
  text.precision(3);
  (text << ... << parts);
  return text.str();
}

// Whether the pair can carry a map, and if not, why.
StartStep judge(const FramePair& pair, const std::vector<StartPoint>& points,
                const MapperOptions& options) {
  StartStep step;
  const int matches = pair.num_matches();
  step.num_matches = matches;
  if (matches < options.start.min_matches) {
    step.reason = Reason::kTooFewMatches;
    step.detail =
        join(matches, " matches with the anchor image, wanted ", options.start.min_matches);
  } else if (pair.relative.reason == Reason::kRelativePoseFailed) {
    step.reason = pair.relative.reason;
    step.detail = join("no relative pose fits enough of ", matches, " matches");
  } else if (!pair.relative.ok()) {
    step.reason = pair.relative.reason;
    step.detail = join("rotation alone explains ", pair.relative.rotation.num_inliers, " of ",
                       matches, " matches");
  } else if (pair.relative.planar) {
    step.reason = Reason::kPlanarScene;
    step.detail = join("a plane explains the ", matches, " matches as well");
  } else if (!(pair.relative.pose.sigma_direction <
               options.start.max_sigma_direction_deg * kDegree)) {
    step.reason = Reason::kDirectionUncertain;
    step.detail = join("direction known to ", pair.relative.pose.sigma_direction / kDegree,
                       " deg, wanted ", options.start.max_sigma_direction_deg);
  } else if (static_cast<int>(points.size()) < options.start.min_points) {
    step.reason = Reason::kTooFewPoints;
    step.detail =
        join(points.size(), " points with a certain depth, wanted ", options.start.min_points);
  } else {
    step.reason = Reason::kNone;
  }
  return step;
}

// The map of the two, solved once; nothing when the filter did not keep enough of it.
std::optional<Map> build_map(const ObservedFrame& i, const ObservedFrame& j, const FramePair& pair,
                             const std::vector<StartPoint>& points, const Camera& camera,
                             const MapperOptions& options) {
  Map map(camera, options);
  map.add_keyframe(i, Rigid3());
  map.add_keyframe(j, Rigid3(pair.relative.pose.i_from_j, pair.relative.pose.direction));
  for (const StartPoint& point : points) {
    const int track = map.add_track({0, point.match.a});
    if (!map.add_sight(track, {1, point.match.b})) continue;  // matches need not be mutual
    map.promote(track, point.point.point, point.point.covariance);
  }
  if (options.edge.enabled) add_edge(map, 0, 1, pair.explained_p(), pair.relative.pose, options);
  // The other matches wait as candidates for a third view.
  for (std::size_t k = 0; k < pair.m.size(); ++k) {
    const Match& m = pair.m[k];
    if (!pair.explains_m(k)) continue;
    if (map.keyframe(0).track[m.a] != kNoTrack || map.keyframe(1).track[m.b] != kNoTrack) continue;
    map.add_sight(map.add_track({0, m.a}), {1, m.b});
  }
  if (map.update().reason != Reason::kNone || map.num_landmarks() < options.start.min_points)
    return std::nullopt;
  return map;
}

// A frame of the start set in the new map, from its matches with either keyframe. There may be many
// of them, and the two see the same place: whichever knows it will do.
std::optional<Rigid3> pose_backwards(const Map& map, const ObservedFrame& observed,
                                     const MapperOptions& options) {
  for (const int keyframe : {1, 0}) {
    const Tracking tracking = relocalize(map, observed, {keyframe}, options);
    if (tracking.ok()) return tracking.world_from_camera;
  }
  return std::nullopt;
}

}  // namespace

MapSign sign_to_start_with(MapSignChoice choice) {
  if (choice == MapSignChoice::kBoth) return MapSign::kBoth;
  return choice == MapSignChoice::kPlus ? MapSign::kPlus : MapSign::kMinus;
}

MapStart::MapStart(const Camera& camera, const MapperOptions& options)
    : camera_(camera), options_(options), planar_(options) {}

// The anchor is too far back to match: its successor is the frame half way to the newest.
void MapStart::give_up_anchor() {
  anchor_ += std::max<std::size_t>(1, (frames_.size() - 1 - anchor_) / 2);
  anchor_ = std::min(anchor_, frames_.size() - 1);
}

StartStep MapStart::add(ObservedFrame observed) {
  StartStep step;
  if (observed.size() < options_.start.min_features) {
    step.detail = join(observed.size(), " features, wanted ", options_.start.min_features);
    return step;
  }
  if (!frames_.empty()) {
    step = compare_with_anchor(observed);
    if (step.reason == Reason::kNone) {
      frames_.clear();
      anchor_ = 0;
      return step;
    }
  } else {
    step.reason = Reason::kNoBaseline;
    step.detail = "the first image is the anchor";
  }
  frames_.push_back(std::move(observed));
  if (step.reason == Reason::kTooFewMatches || step.reason == Reason::kRelativePoseFailed)
    give_up_anchor();
  if (static_cast<int>(frames_.size()) > options_.start.max_frames) {
    frames_.pop_front();
    anchor_ = anchor_ > 0 ? anchor_ - 1 : 0;
  }
  return step;
}

void MapStart::choose_sign(MapSign sign, ObservedFrame& newest) {
  newest.map_sign = sign;
  for (ObservedFrame& frame : frames_) frame.map_sign = sign;
}

StartStep MapStart::compare_with_anchor(ObservedFrame& observed) {
  const ObservedFrame& anchor = frames_[anchor_];
  FramePair pair = relate(anchor, observed, camera_.radians_per_pixel(), options_);
  if (options_.map_sign == MapSignChoice::kMerit && pair.relative.ok()) {
    const MapSign better = sign_of_longer_tracks(pair, observed.map_sign);
    if (better != observed.map_sign) {
      choose_sign(better, observed);
      pair = relate(anchor, observed, camera_.radians_per_pixel(), options_);
    }
  }
  if (pair.relative.ok() && pair.relative.planar) planar_.decide(anchor, observed, pair);
  const std::vector<StartPoint> points = pair.relative.ok()
                                             ? certain_points(anchor, observed, pair, options_)
                                             : std::vector<StartPoint>();
  StartStep step = judge(pair, points, options_);
  if (step.reason != Reason::kNone) return step;

  std::optional<Map> map = build_map(anchor, observed, pair, points, camera_, options_);
  if (!map) {
    step.reason = Reason::kTooFewPoints;
    step.detail = join("the filter kept too few of ", points.size(), " points");
    return step;
  }
  step.started.emplace(StartedMap{std::move(*map), {}});
  StartedMap& started = *step.started;
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const auto pose = k == anchor_ ? std::optional<Rigid3>(started.map.pose(0))
                                   : pose_backwards(started.map, frames_[k], options_);
    if (pose) started.posed.push_back({frames_[k].frame.time_us, *pose});
  }
  return step;
}

}  // namespace eifmap
