// What a new keyframe's measurements differ by from what the map predicts, next to what they should
// differ by: before any of them has moved the map.
#pragma once

#include <optional>

#include "map/frame_covariance.h"
#include "map/map.h"
#include "map/tracking.h"

namespace eifmap {

// Normalized innovations squared of measurements of one kind: each chi-square distributed when the
// map and the noise are as claimed.
struct NisSum {
  double squared = 0;  // of those within the gate
  int count = 0;       // of those within the gate
  int beyond = 0;      // and of the others, which are outliers whatever the noise
  // Degrees of freedom that a fit to the measurements themselves has taken from the sum.
  double fitted = 0;
};

struct Innovations {
  NisSum sights, edges;
};

// Measurements beyond these, in sigmas of their innovation, are left out of the sum, and its
// expectation allows for that (nis_monitor.h). Of a sight: no more than AbsolutePoseOptions'
// gate_sigma, so that among the sights of a Tracking none is missing within.
inline constexpr double kSightNisGate = 3.5, kEdgeNisGate = 5.5;

// Of the landmarks that a frame was posed by, 2 degrees of freedom each: the residuals that the fit
// of its pose has left, whitened by what keypoint and landmark are said to be off by, given the
// keyframes. Innovations from before the fit would have the pose's error in common, and of that,
// where there is no motion model, nothing is known beforehand; the fit takes it out of them with 6
// degrees of freedom, and with it most of what the keyframes around are off by. What is left is
// next to independent from sight to sight.
NisSum innovations_of_sights(const Map& map, const ObservedFrame& observed,
                             const Tracking& tracking);

// Of a relative pose, 5 degrees of freedom: S = R + H P H' with the joint covariance P of keyframe
// `edge.i` and the frame posed by its sights, none of whose features an edge uses. Nothing where
// the filter cannot tell. `edge.j` is the frame's, and added to the filter already; `variance`:
// what R is multiplied by.
std::optional<double> squared_innovation(const Map& map, const FilterEdge& edge,
                                         const FrameError& error, double variance);

}  // namespace eifmap
