#include "degenerate/judgement.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "geometry/robust.h"

namespace eifmap::test {
namespace {

// A map is wrong with more than this of the path, or of the depth where the path is short.
constexpr double kRight = 0.02;
constexpr double kRightDepths = 0.1;  // relative error of the landmarks' depths, median
constexpr double kSameScale = 0.05;
constexpr int kFewPoses = 10;  // with fewer a similarity transform fits anything

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char buffer[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

class Judge {
 public:
  Judge(const Case& which, const SimulatedWorld& world, const CaseRun& run)
      : case_(which), world_(world), run_(run) {}

  Verdict operator()() {
    maps();
    begin();
    waiting();
    event();
    moving();
    tracked();
    calibration();
    summary();
    return std::move(verdict_);
  }

 private:
  int size() const { return static_cast<int>(run_.results.size()); }
  const FrameResult& result(int i) const { return run_.results[static_cast<std::size_t>(i)]; }
  bool is(int i, TrackingState state) const { return result(i).state == state; }
  int frame_at(double seconds) const {
    return std::clamp(static_cast<int>(std::ceil(seconds * case_.world.rate_hz)), 0, size());
  }
  bool has_event() const { return case_.to_s > case_.from_s; }
  int count(int first, int end, TrackingState state) const {
    int number = 0;
    for (int i = first; i < end; ++i) number += is(i, state);
    return number;
  }
  // FrameResult::num_moving, the mean over frames [first, end).
  double mean_moving(int first, int end) const {
    double sum = 0;
    for (int i = first; i < end; ++i) sum += result(i).num_moving;
    return end > first ? sum / (end - first) : 0;
  }
  // The last map that was tracked in within frames [first, end); 0 none.
  std::int64_t map_in(int first, int end) const {
    for (int i = end - 1; i >= first; --i)
      if (is(i, TrackingState::kTracking)) return result(i).map_id;
    return 0;
  }
  void fault(std::string sentence) { verdict_.faults.push_back(std::move(sentence)); }

  double typical_depth() const;
  double scale(std::int64_t map, int first, int end) const;
  Reason most_said_while_waiting() const;
  void maps();
  void begin();
  void waiting();
  void event();
  void growth(int from, int to);
  void moving();
  void tracked();
  void calibration();
  void summary();

  const Case& case_;
  const SimulatedWorld& world_;
  const CaseRun& run_;
  Verdict verdict_;
};

double Judge::typical_depth() const {
  const cv::Mat depth = world_.depth(0);
  std::vector<float> values;
  for (int y = 0; y < depth.rows; y += 8)
    for (int x = 0; x < depth.cols; x += 8)
      if (depth.at<float>(y, x) > 0) values.push_back(depth.at<float>(y, x));
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Map units a true metre over frames [first, end): the median over short parts of the way, since a
// step by which the map corrects the poses is no motion. 0 when the map has no such part.
double Judge::scale(std::int64_t map, int first, int end) const {
  constexpr int kStep = 3;
  std::vector<double> scales;
  for (int i = first; i + kStep < end; ++i) {
    const FrameResult &a = result(i), &b = result(i + kStep);
    if (a.state != TrackingState::kTracking || b.state != TrackingState::kTracking ||
        a.map_id != map || b.map_id != map)
      continue;
    const double truth =
        (world_.world_from_camera(i).translation - world_.world_from_camera(i + kStep).translation)
            .norm();
    if (truth > 0)
      scales.push_back((a.map_from_camera.translation - b.map_from_camera.translation).norm() /
                       truth);
  }
  return scales.empty() ? 0 : take_median(scales);
}

void Judge::maps() {
  const double depth = typical_depth();
  for (const PublishedMap& map : run_.maps) {
    const MapError error = map_error(map, world_, run_);
    const double allowed = kRight * std::max(error.path, depth);
    verdict_.summary +=
        text("  map %d: %d poses on %.1f m, rmse %.3f m, depths %.1f %% off, %.0f %% of %d wrong;",
             static_cast<int>(map.id), error.poses, error.path, error.rmse, 100 * error.depth_error,
             100 * error.wrong_points, error.points);
    if (case_.calibration_suspect) continue;
    if (error.poses >= kFewPoses && error.scale == 0)
      fault(text("map %d has no scale", static_cast<int>(map.id)));
    if (error.rmse > allowed)
      fault(text("map %d is wrong: error %.3f m, allowed %.3f", static_cast<int>(map.id),
                 error.rmse, allowed));
    if (error.depth_error > kRightDepths)
      fault(text("map %d is wrong: its depths are %.0f %% off", static_cast<int>(map.id),
                 100 * error.depth_error));
  }
}

void Judge::begin() {
  int first = 0;
  while (first < size() && !is(first, TrackingState::kTracking)) ++first;
  const double at = first / case_.world.rate_hz;
  verdict_.summary += first < size() ? text("  begun at %.2f s;", at) : "  no map;";
  if (case_.begin == Begin::kNever && first < size())
    fault(text("a map was begun at %.2f s, wanted none", at));
  if (case_.begin == Begin::kInTime && at > case_.start_by_s)
    fault(text("no map was begun by %.2f s", case_.start_by_s));
}

Reason Judge::most_said_while_waiting() const {
  std::map<Reason, int> said;
  for (int i = 1; i < size(); ++i)
    if (is(i, TrackingState::kStarting)) ++said[result(i).reason];
  Reason most = Reason::kNone;
  int times = 0;
  for (const auto& [reason, number] : said)
    if (number > times) most = reason, times = number;
  return most;
}

void Judge::waiting() {
  const int waited = count(0, size(), TrackingState::kStarting);
  const Reason reason = most_said_while_waiting();
  verdict_.summary +=
      text("  %d waited (%s), %d tracked, %d lost;", waited, describe(reason).name,
           count(0, size(), TrackingState::kTracking), count(0, size(), TrackingState::kLost));
  if (case_.waits_with && waited > size() / 2 && reason != *case_.waits_with)
    fault(text("it waits with %s, wanted %s", describe(reason).name,
               describe(*case_.waits_with).name));
}

void Judge::event() {
  if (!has_event()) return;
  const int from = frame_at(case_.from_s), to = frame_at(case_.to_s);
  const int lost = count(from, size(), TrackingState::kLost);
  if (case_.lost_during && count(from, to, TrackingState::kLost) == 0) fault("LOST was not said");
  const std::int64_t before = map_in(0, from), after = map_in(to, size());
  if (case_.same_map_after && after != before)
    fault(text("map %d before, %d after", static_cast<int>(before), static_cast<int>(after)));
  if (before != 0 && after != 0 && before != after && lost == 0) fault("a new map without a word");
  const double scale_before = scale(before, 0, from), scale_after = scale(after, to, size());
  verdict_.summary += text("  scale %.3f then %.3f;", scale_before, scale_after);
  if (before == after && scale_before > 0 && scale_after > 0 &&
      std::abs(scale_after / scale_before - 1) > kSameScale)
    fault(text("scale %.3f before, %.3f after", scale_before, scale_after));
  if (!case_.grows_during) growth(from, to);
}

void Judge::growth(int from, int to) {
  constexpr int kKeyframes = 3;
  constexpr double kLandmarks = 0.05;
  const auto at = [](const std::vector<std::int64_t>& values, int i) {
    return static_cast<int>(values[static_cast<std::size_t>(i)]);
  };
  const int k0 = at(run_.keyframes, from), k1 = at(run_.keyframes, to - 1);
  const int l0 = at(run_.landmarks, from), l1 = at(run_.landmarks, to - 1);
  verdict_.summary += text("  %d to %d keyframes, %d to %d landmarks;", k0, k1, l0, l1);
  if (k1 - k0 > kKeyframes || std::abs(l1 - l0) > kLandmarks * l0)
    fault(text("the map grew from %d to %d keyframes, from %d to %d landmarks", k0, k1, l0, l1));
}

void Judge::moving() {
  constexpr double kSome = 10, kNearNone = 0.5;  // matches an image
  // Its front is in view a little before.
  const int from = case_.moves_during ? frame_at(case_.from_s - 1) : size();
  const double still = mean_moving(0, from);
  const double moved = mean_moving(from, frame_at(case_.to_s));
  verdict_.summary += text("  %.2f moving matches an image", mean_moving(0, size()));
  verdict_.summary += case_.moves_during ? text(", before %.2f, during %.1f;", still, moved) : ";";
  if (case_.moves_during && moved < kSome)
    fault(text("%.1f moving matches an image are counted, wanted %.0f", moved, kSome));
  if ((case_.moves_during || case_.stands_still) && still > kNearNone)
    fault(text("%.2f moving matches an image are counted where nothing moves", still));
}

void Judge::tracked() {
  if (case_.tracked_after == 0) return;
  const int first = frame_at(has_event() ? case_.to_s : case_.start_by_s);
  if (first >= size()) return fault("too few images to judge what comes after it");
  const double share =
      static_cast<double>(count(first, size(), TrackingState::kTracking)) / (size() - first);
  if (share < case_.tracked_after)
    fault(text("%.0f %% tracked after it, wanted %.0f %%", 100 * share, 100 * case_.tracked_after));
}

void Judge::calibration() {
  constexpr Reason kSuspect = Reason::kCalibrationSuspect;
  int first = 0;
  while (first < size() && result(first).reason != kSuspect) ++first;
  if (first < size())
    verdict_.summary += text("  %s from %.2f s on: %s;", describe(kSuspect).name,
                             first / case_.world.rate_hz, result(first).detail.c_str());
  if (first < size() && !case_.calibration_suspect)
    fault("the calibration is right, and was called suspect");
  if (first == size() && case_.calibration_suspect && !run_.maps.empty())
    fault(text("%s was not said", describe(kSuspect).name));
}

void Judge::summary() {
  if (verdict_.summary.ends_with(";")) verdict_.summary.pop_back();
}

}  // namespace

Verdict judge(const Case& which, const SimulatedWorld& world, const CaseRun& run) {
  return Judge(which, world, run)();
}

}  // namespace eifmap::test
