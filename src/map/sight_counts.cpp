#include "map/sight_counts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

constexpr double kDegree = M_PI / 180;

}  // namespace

bool sees(const std::vector<LandmarkSight>& sights, int track) {
  const auto place =
      std::lower_bound(sights.begin(), sights.end(), track,
                       [](const LandmarkSight& sight, int t) { return sight.track < t; });
  return place != sights.end() && place->track == track;
}

SafeView::SafeView(const Camera& camera) {
  constexpr double kMargin = 0.05;  // of the image's height: about a large blob's radius
  constexpr int kSteps = 16;        // along each edge, which a lens bends
  const double left = kMargin * camera.height, top = left;
  const double right = camera.width - 1 - left, bottom = camera.height - 1 - top;
  min_.setConstant(-std::numeric_limits<double>::infinity());
  max_.setConstant(std::numeric_limits<double>::infinity());
  // NaN, of a place beyond what is used of a lens, changes nothing.
  const auto at = [&camera](double u, double v) { return camera.normalized_from_pixel({u, v}); };
  for (int i = 0; i <= kSteps; ++i) {
    const double u = left + (right - left) * i / kSteps, v = top + (bottom - top) * i / kSteps;
    min_.x() = std::fmax(min_.x(), at(left, v).x());
    max_.x() = std::fmin(max_.x(), at(right, v).x());
    min_.y() = std::fmax(min_.y(), at(u, top).y());
    max_.y() = std::fmin(max_.y(), at(u, bottom).y());
  }
}

SafeView::SafeView(const ObservedFrame& observed) {
  min_.setConstant(std::numeric_limits<double>::infinity());
  max_.setConstant(-std::numeric_limits<double>::infinity());
  for (const Eigen::Vector2d& x : observed.x) min_ = min_.cwiseMin(x), max_ = max_.cwiseMax(x);
}

std::vector<int> landmarks_expected(const Map& map, const SafeView& view,
                                    const Rigid3& world_from_camera,
                                    const std::vector<int>& tracks) {
  // A blob is found again at most half as large again, and its surroundings look alike within:
  constexpr double kMaxZoom = 1.5;
  static const double kMinCosine = std::cos(30 * kDegree);
  const Projector projector(world_from_camera);
  std::vector<int> expected;
  for (const int track : tracks) {
    const Eigen::Vector3d& point = map.position(track);
    Eigen::Vector2d x;
    if (!projector(point, x) || !view.contains(x)) continue;
    const Rigid3& seen_from = map.pose(map.track(track).sights.back().keyframe);
    const Eigen::Vector3d now = point - world_from_camera.translation;
    const Eigen::Vector3d then = point - seen_from.translation;
    const double product = now.norm() * then.norm();
    if (now.norm() > kMaxZoom * then.norm() || then.norm() > kMaxZoom * now.norm()) continue;
    if (now.dot(then) < kMinCosine * product) continue;
    expected.push_back(track);
  }
  return expected;
}

// By a degree or by a part of the depth that shows as much: a tenth of the way to a keyframe.
bool SightCounts::is_elsewhere(const Map& map, const Tracking& tracking) const {
  constexpr double kTurn = 0.5 * kDegree, kStep = 0.005;
  if (!last_) return true;
  const Rigid3& pose = tracking.world_from_camera;
  if (pose.rotation.angularDistance(last_->rotation) > kTurn) return true;
  std::vector<double> distances;
  for (const LandmarkSight& sight : tracking.sights)
    distances.push_back((map.position(sight.track) - pose.translation).norm());
  return (pose.translation - last_->translation).norm() > kStep * take_median(distances);
}

void SightCounts::add(const Map& map, const Tracking& tracking) {
  if (!is_elsewhere(map, tracking)) return;
  last_ = tracking.world_from_camera;
  for (const int track :
       landmarks_expected(map, view_, tracking.world_from_camera, tracking.looked_for)) {
    Count& count = counts_[track];
    ++count.expected;
    count.seen += sees(tracking.sights, track);
  }
  forget_removed(map);
}

// Numbers of tracks are not used again, and of those that there ever were most are no more. Not
// looked at before half of the counts can be theirs.
void SightCounts::forget_removed(const Map& map) {
  if (counts_.size() <= 2 * static_cast<std::size_t>(map.num_landmarks())) return;
  std::erase_if(counts_, [&map](const auto& of) { return !map.track(of.first).is_landmark(); });
}

void SightCounts::include(const SightCounts& other, const Appended& appended) {
  for (const auto& [track, count] : other.counts_) counts_[appended.first_track + track] = count;
  forget_last();
}

std::vector<int> SightCounts::hardly_seen(const Map& map) const {
  constexpr int kEnough = 12;  // expected sights before a landmark is judged
  constexpr double kShare = 0.25;
  std::vector<int> tracks;
  for (const auto& [track, count] : counts_)
    if (count.expected >= kEnough && count.seen < kShare * count.expected &&
        map.track(track).is_landmark())
      tracks.push_back(track);
  return tracks;
}

}  // namespace eifmap
