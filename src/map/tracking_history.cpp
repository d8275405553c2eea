#include "map/tracking_history.h"

#include <algorithm>
#include <vector>

#include "geometry/robust.h"

namespace eifmap {
namespace {

constexpr std::size_t kFrames = 15;
// Of a step, times the larger of the one before and the usual one; smaller ones are never odd.
constexpr double kOddRatio = 2.5, kSmallStep = 12;  // the latter in pixels
// What may be left of an odd step, as a share of it, by one that returns.
constexpr double kLeft = 0.5;

}  // namespace

bool TrackingHistory::returns(const Eigen::Vector2d& step_px) const {
  return odd_ && (*odd_ + step_px).norm() < kLeft * odd_->norm();
}

void TrackingHistory::push(double length_px) {
  lengths_px_.push_back(length_px);
  if (lengths_px_.size() > kFrames) lengths_px_.pop_front();
}

bool TrackingHistory::is_odd_step(const Eigen::Vector2d& step_px) const {
  const double length = step_px.norm();
  if (lengths_px_.empty() || length < kSmallStep || returns(step_px)) return false;
  std::vector<double> usual(lengths_px_.begin(), lengths_px_.end());
  double before = lengths_px_.back();
  if (odd_ && odd_->dot(step_px) > 0) before = odd_->norm();
  return length > kOddRatio * std::max(before, take_median(usual));
}

void TrackingHistory::add(const Eigen::Vector2d& step_px) {
  if (returns(step_px)) {
    push((*odd_ + step_px).norm());
    odd_.reset();
  } else if (is_odd_step(step_px)) {
    odd_ = step_px + odd_.value_or(Eigen::Vector2d::Zero());
  } else {
    if (odd_) push(odd_->norm());
    odd_.reset();
    push(step_px.norm());
  }
}

}  // namespace eifmap
