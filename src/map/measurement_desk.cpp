#include "map/measurement_desk.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <utility>

namespace eifmap {
namespace {

// Nobody measures further ahead of the images: a wrong clock, which must not fill the desk.
constexpr std::int64_t kMostAheadUs = 60'000'000;

// Frames kept: a distance may reach back some ten minutes at 30 Hz.
constexpr std::size_t kMostFrames = 20'000;

PlacedPoint point_of(const PlacedFrame& frame, const Eigen::Vector3d& lever) {
  const Eigen::Matrix3d turn = frame.keyframe_from_camera.matrix();
  const Eigen::Matrix3d by_turn = turn * skew(lever);
  PlacedPoint point;
  point.keyframe = frame.keyframe;
  point.offset = frame.keyframe_from_camera.translation;
  point.lever = turn * lever;
  point.offset_covariance = frame.centre_covariance.cast<double>();
  point.lever_covariance = by_turn * frame.turn_covariance.cast<double>() * by_turn.transpose();
  return point;
}

}  // namespace

Reason MeasurementDesk::add(const AbsoluteMeasurement& measurement) {
  Reason reason = check_measurement(measurement);
  if (reason == Reason::kNone && num_waiting() >= options_.max_waiting)
    reason = Reason::kTooManyMeasurements;
  if (reason == Reason::kNone)
    waiting_.push_back({measurement});
  else
    refused_.add(measurement.kind, reason);
  return reason;
}

void MeasurementDesk::add_frame(const PlacedFrame& frame) {
  frames_.push_back(frame);
  if (frames_.size() > kMostFrames) frames_.pop_front();
}

void MeasurementDesk::make_keyframe(std::int64_t time_us, int keyframe) {
  const auto frame = std::find_if(frames_.rbegin(), frames_.rend(),
                                  [time_us](const PlacedFrame& f) { return f.time_us == time_us; });
  if (frame != frames_.rend()) *frame = PlacedFrame::as_keyframe(time_us, keyframe);
}

void PlacedFrame::grow(double factor) {
  keyframe_from_camera.translation *= factor;
  centre_covariance *= static_cast<float>(factor * factor);
}

void MeasurementDesk::make_metric(double metres_per_unit) {
  for (PlacedFrame& frame : frames_) frame.grow(metres_per_unit);
}

void MeasurementDesk::grow(const std::vector<double>& growth) {
  for (PlacedFrame& frame : frames_)
    if (frame.keyframe >= 0) frame.grow(growth[static_cast<std::size_t>(frame.keyframe)]);
}

void MeasurementDesk::include(const std::deque<PlacedFrame>& frames, const Appended& appended,
                              bool is_in_other) {
  std::deque<PlacedFrame> others = frames;
  for (PlacedFrame& frame : is_in_other ? frames_ : others) {
    if (frame.keyframe < 0) continue;
    frame.keyframe += appended.first_keyframe;
    frame.grow(appended.growth);
  }
  std::deque<PlacedFrame> all;
  std::merge(others.begin(), others.end(), frames_.begin(), frames_.end(), std::back_inserter(all),
             [](const PlacedFrame& a, const PlacedFrame& b) { return a.time_us < b.time_us; });
  while (all.size() > kMostFrames) all.pop_front();
  frames_ = std::move(all);
}

Reason MeasurementDesk::find(const Map& map, std::int64_t time_us, Between& between) const {
  const auto after = std::lower_bound(
      frames_.begin(), frames_.end(), time_us,
      [](const PlacedFrame& frame, std::int64_t time) { return frame.time_us < time; });
  const auto distance = [time_us](const PlacedFrame& frame) {
    return 1e-6 * static_cast<double>(std::llabs(frame.time_us - time_us));
  };
  const PlacedFrame* other = after == frames_.begin() ? nullptr : &*std::prev(after);
  const PlacedFrame* nearest = after == frames_.end() ? nullptr : &*after;
  if (!nearest || (other && distance(*other) < distance(*nearest))) std::swap(nearest, other);
  if (!nearest || distance(*nearest) > options_.max_dt_s) return Reason::kMeasurementWithoutFrame;
  if (nearest->keyframe < 0 || nearest->keyframe >= map.num_keyframes())
    return Reason::kMeasurementWithoutPose;
  between.nearest = nearest;
  if (!other || other->keyframe < 0 || distance(*nearest) == 0) return Reason::kNone;
  between.other = other;
  between.share = distance(*nearest) / (distance(*nearest) + distance(*other));
  return Reason::kNone;
}

// The camera's place at a time: that of the frame nearest to it, moved along the way to the frame
// on the time's other side.
Reason MeasurementDesk::place(const Map& map, std::int64_t time_us, const Eigen::Vector3d& lever,
                              PlacedPoint& point) const {
  Between between;
  if (const Reason reason = find(map, time_us, between); reason != Reason::kNone) return reason;
  point = point_of(*between.nearest, lever);
  if (!between.other) return Reason::kNone;
  const PlacedPoint beyond = point_of(*between.other, lever);
  const Rigid3 nearest_from_other = map.pose(point.keyframe).inverse() * map.pose(beyond.keyframe);
  point.offset += between.share * (nearest_from_other * beyond.offset - point.offset);
  point.lever += between.share * (nearest_from_other.rotation * beyond.lever - point.lever);
  return Reason::kNone;
}

// The same of how the camera is turned.
Reason MeasurementDesk::place_gravity(const Map& map, const AbsoluteMeasurement& m,
                                      PlacedMeasurement& placed) const {
  Between between;
  if (const Reason reason = find(map, m.time_us, between); reason != Reason::kNone) return reason;
  const PlacedFrame& nearest = *between.nearest;
  Eigen::Quaterniond turn = nearest.keyframe_from_camera.rotation;
  if (between.other) {
    const Eigen::Quaterniond nearest_from_other = map.pose(nearest.keyframe).rotation.conjugate() *
                                                  map.pose(between.other->keyframe).rotation;
    turn = turn.slerp(between.share,
                      nearest_from_other * between.other->keyframe_from_camera.rotation);
  }
  placed.points.front().keyframe = nearest.keyframe;
  placed.value = (turn * m.down).normalized();
  placed.covariance =
      m.sigma * m.sigma * Eigen::Matrix3d::Identity() +
      turn * nearest.turn_covariance.cast<double>() * turn.toRotationMatrix().transpose();
  return Reason::kNone;
}

Reason MeasurementDesk::place_way(const Map& map, const AbsoluteMeasurement& m,
                                  PlacedMeasurement& placed) const {
  const Eigen::Vector3d no_lever = Eigen::Vector3d::Zero();
  if (const Reason reason = place(map, m.time_us, no_lever, placed.points.front());
      reason != Reason::kNone)
    return reason;
  if (m.kind == MeasurementKind::kOdometry)
    for (int k = 0; k < map.num_keyframes(); ++k) {
      const std::int64_t time_us = map.keyframe(k).time_us;
      if (time_us <= m.time_us || time_us >= m.until_us || map.is_removed(k)) continue;
      placed.points.emplace_back();
      placed.points.back().keyframe = k;
    }
  placed.points.emplace_back();
  if (placed.points.size() > kMostPoints) return Reason::kMeasurementTooLong;
  return place(map, m.until_us, no_lever, placed.points.back());
}

Reason MeasurementDesk::place(const Map& map, std::int64_t map_id, const AbsoluteMeasurement& m,
                              PlacedMeasurement& placed) const {
  placed.kind = m.kind;
  placed.points.resize(1);
  placed.value = {m.length, 0, 0};
  placed.covariance(0, 0) = m.sigma * m.sigma;
  switch (m.kind) {
    case MeasurementKind::kPosition:
      placed.value = m.position;
      placed.covariance = m.covariance;
      return place(map, m.time_us, m.lever, placed.points.front());
    case MeasurementKind::kGravity:
      return place_gravity(map, m, placed);
    case MeasurementKind::kLandmarks:
      placed.points.clear();
      for (std::size_t k = 0; k < 2; ++k) {
        if (m.map_id != map_id || m.landmark[k] >= map.num_tracks() ||
            !map.track(static_cast<int>(m.landmark[k])).is_landmark())
          return Reason::kMeasurementWithoutLandmark;
        placed.tracks[k] = static_cast<int>(m.landmark[k]);
      }
      return Reason::kNone;
    case MeasurementKind::kDistance:
    case MeasurementKind::kOdometry:
      break;
  }
  return place_way(map, m, placed);
}

MeasurementDesk::Taken MeasurementDesk::take(const Map& map, std::int64_t map_id) {
  Taken taken;
  if (frames_.empty()) return taken;
  std::erase_if(waiting_, [this](const Entry& entry) {
    const AbsoluteMeasurement& m = entry.measurement;
    if (usable_from_us(m) <= frames_.back().time_us + kMostAheadUs) return false;
    refused_.add(m.kind, Reason::kMeasurementWithoutFrame);
    return true;
  });
  const auto is_due = [this](const Entry& entry) {
    return usable_from_us(entry.measurement) <= frames_.back().time_us;
  };
  for (const Entry& entry : waiting_) {
    if (!is_due(entry)) continue;
    PlacedMeasurement placed;
    const Reason reason = place(map, map_id, entry.measurement, placed);
    if (reason == Reason::kNone) {
      taken.placed.push_back(std::move(placed));
      taken.entries.push_back(entry);
    } else {
      refused_.add(entry.measurement.kind, reason);
    }
  }
  std::erase_if(waiting_, is_due);
  return taken;
}

void MeasurementDesk::put_back(std::vector<Entry> entries, Reason reason) {
  constexpr int kMostFailures = 2;
  if (reason != Reason::kNone && reason != Reason::kMapFull)
    std::erase_if(entries, [&](Entry& entry) {
      if (++entry.failures < kMostFailures) return false;
      refused_.add(entry.measurement.kind, reason);
      return true;
    });
  waiting_.insert(waiting_.begin(), entries.begin(), entries.end());
}

}  // namespace eifmap
