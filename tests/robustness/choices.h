// Which of a recording's frames something happens to.
#pragma once

#include <vector>

#include "support/random.h"

namespace eifmap::test {

// Of n frames those that are left when `share` of them, rounded, are lost in bursts of 2 to 8 (the
// last burst may be shorter), with at least one left before, between and behind. Ascending. Throws
// std::invalid_argument on a share outside [0, 0.5].
std::vector<int> without_bursts(int n, double share, Random& random);

// Of each of n frames, as of a camera that exposes anew: 1, then 1 - step or 1 + step, then 1 and
// so on, each for 10 to 30 frames.
std::vector<double> gain_steps(int n, double step, Random& random);

// How many of `count` strange frames come between frame i and i + 1, for i in [0, n - 1): at random
// places. Throws std::invalid_argument without any place.
std::vector<int> between(int n, int count, Random& random);

}  // namespace eifmap::test
