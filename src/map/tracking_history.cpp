#include "map/tracking_history.h"

#include <algorithm>
#include <vector>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

constexpr std::size_t kFrames = 15;
// Of a step, times the larger of the one before and the usual one; smaller ones are never odd.
constexpr double kOddRatio = 3, kSmallStep = 12;  // the latter in pixels

double median_of(const std::deque<double>& values) {
  std::vector<double> copy(values.begin(), values.end());
  return take_median(copy);
}

}  // namespace

void TrackingHistory::add(double step_px) {
  steps_px_.push_back(step_px);
  if (steps_px_.size() > kFrames) steps_px_.pop_front();
}

bool TrackingHistory::is_odd_step(double step_px) const {
  if (steps_px_.empty() || step_px < kSmallStep) return false;
  return step_px > kOddRatio * std::max(steps_px_.back(), median_of(steps_px_));
}

double step_in_pixels(const Map& map, const std::vector<LandmarkSight>& sights, const Rigid3& from,
                      const Rigid3& to) {
  const Projector before(from), now(to);
  std::vector<double> steps;
  for (const LandmarkSight& sight : sights) {
    Eigen::Vector2d a, b;
    if (before(map.position(sight.track), a) && now(map.position(sight.track), b))
      steps.push_back((a - b).norm());
  }
  return take_median(steps) / map.radians_per_pixel();
}

}  // namespace eifmap
