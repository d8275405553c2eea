// What is usual of the frames tracked lately: what an odd one is told by. A torn or shifted image
// may look like a step of the camera that none has taken, and such a frame must not enter the map.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

namespace eifmap {

class TrackingHistory {
 public:
  // Of each tracked frame: how its landmarks moved in the image since the frame before
  // (median_step() of image_shift.h, in pixels).
  void add(const Eigen::Vector2d& step_px);

  // Much larger than the step before it and than the usual one, and no way back from an odd one.
  // Where the camera does begin to move faster, the next step goes on, and is no longer odd.
  bool is_odd_step(const Eigen::Vector2d& step_px) const;

 private:
  bool returns(const Eigen::Vector2d& step_px) const;
  void push(double length_px);

  std::deque<double> lengths_px_;  // of the last steps: what becomes usual is soon taken for it
  std::optional<Eigen::Vector2d> odd_;  // where the last frame is from the last that was not odd
};

}  // namespace eifmap
