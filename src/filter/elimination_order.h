// In which order the poses are eliminated: it decides how many blocks of the factor are not zero,
// and how many are another when a new keyframe comes.
#pragma once

#include <vector>

#include "filter/block_matrix.h"

namespace eifmap {

// Poses by position: the first is eliminated first. The latest `recent` poses come last, in their
// own order, since the next measurements are theirs: what is eliminated before them stays. The
// cheapest of the present order, the poses' own and minimum degree (CAMD). Not METIS: it sets the
// process's signal handlers and draws from its one stream of random numbers. `late` (-1: none): a
// block that meets many others and so comes last before the latest.
std::vector<int> elimination_order(const BlockMatrix& matrix, int recent, int late,
                                   const std::vector<int>& present);

// Multiplications that the factorization takes, in blocks.
double elimination_cost(const BlockMatrix& matrix, const std::vector<int>& order);

}  // namespace eifmap
