// In which order the poses are eliminated: it decides how many blocks of the factor are not zero,
// and how many are another when a new keyframe comes.
#pragma once

#include <vector>

#include "filter/block_matrix.h"

namespace eifmap {

// Poses by position: the first is eliminated first. The latest `recent` poses come last, in their
// own order, since the next measurements are theirs: what is eliminated before them stays. The
// cheapest of the poses' own order, minimum degree (CAMD) and nested dissection (METIS).
std::vector<int> elimination_order(const BlockMatrix& matrix, int recent);

// Multiplications that the factorization takes, in blocks.
double elimination_cost(const BlockMatrix& matrix, const std::vector<int>& order);

}  // namespace eifmap
