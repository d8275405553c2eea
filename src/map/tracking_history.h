// What is usual of the frames tracked lately: what an odd one is told by.
#pragma once

#include <algorithm>
#include <deque>
#include <vector>

namespace eifmap {

class TrackingHistory {
 public:
  // Of each tracked frame: of the landmarks found, the share that agrees with the pose.
  void add(double inlier_ratio) {
    ratios_.push_back(inlier_ratio);
    if (ratios_.size() > kFrames) ratios_.pop_front();
  }
  // The median of the last frames, refused ones included: what becomes usual is soon taken for it.
  // 0 before the first.
  double usual_inlier_ratio() const {
    if (ratios_.empty()) return 0;
    std::vector<double> sorted(ratios_.begin(), ratios_.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
  }

 private:
  static constexpr std::size_t kFrames = 15;
  std::deque<double> ratios_;
};

}  // namespace eifmap
