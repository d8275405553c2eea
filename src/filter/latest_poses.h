// The latest poses' part of the poses' system, while the others stand still.
#pragma once

#include <Eigen/Core>

#include "filter/block_matrix.h"

namespace eifmap {

// Solves the diagonal part of `matrix` of its last `count` blocks but `standing` (-1: none), dense.
// `x`: as long as `right_side`, zero for the others. False when that part is not positive definite.
bool solve_latest(const BlockMatrix& matrix, const Eigen::VectorXd& right_side, int count,
                  int standing, Eigen::VectorXd& x);

}  // namespace eifmap
