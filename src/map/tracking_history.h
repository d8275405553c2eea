// What is usual of the frames tracked lately: what an odd one is told by. A torn or shifted image
// may look like a step of the camera that none has taken, and such a frame must not enter the map.
#pragma once

#include <cstddef>
#include <deque>

#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

class TrackingHistory {
 public:
  // Of each tracked frame: step_in_pixels().
  void add(double step_px);

  // Much larger than the step before it and than the usual one. Where the camera does begin to move
  // faster, the next step is as large, and no longer odd.
  bool is_odd_step(double step_px) const;

 private:
  std::deque<double> steps_px_;  // of the last frames, odd ones included: what becomes usual is
                                 // soon taken for it
};

// How far the landmarks of `sights` move in the image from one pose to the other: the median.
double step_in_pixels(const Map& map, const std::vector<LandmarkSight>& sights, const Rigid3& from,
                      const Rigid3& to);

}  // namespace eifmap
