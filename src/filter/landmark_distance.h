// The distance of two landmarks as a measurement of the poses that see them. The filter eliminates
// landmarks from the poses' matrix each by itself, and a measurement between two would tie them
// together there. So each is taken for what the poses make of it, a = V_a^-1 (b_a - W_a' delta),
// and what its own sights leave open, V_a^-1, is the measurement's noise: for the poses that is
// exact, and the landmarks themselves move with them alone.
#pragma once

#include "filter/absolute_observation.h"
#include "filter/filter_state.h"

namespace eifmap {

struct DistanceRows {
  AbsoluteRows rows;  // of all poses that see either, ascending
  // Variance of the distance by what each landmark's own sights leave open; as the filter counts
  // it, so not yet times its variance().
  double of_a = 0, of_b = 0;
};

// At the landmarks' present places and linearizations. Of two at one place the derivative is zero.
DistanceRows linearize_distance(const FilterLandmark& a, const FilterLandmark& b, double metres);

}  // namespace eifmap
