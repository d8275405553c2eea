// Cholesky factorization of a sparse symmetric matrix of 6x6 blocks. The only file that knows
// CHOLMOD.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace eifmap {

inline constexpr int kPoseDof = 6;
using PoseBlock = Eigen::Matrix<double, kPoseDof, kPoseDof>;

// The upper triangle, in block columns: column a holds the blocks (b, a) with b <= a, rows
// ascending, the diagonal block last.
struct BlockMatrix {
  int size = 0;            // block rows = block columns
  std::vector<int> start;  // size + 1: blocks of column a are [start[a], start[a + 1])
  std::vector<int> row;    // block row of each block
  std::vector<PoseBlock> block;

  void set_zero();
  // The block (b, a), b <= a; it must be in the pattern.
  PoseBlock& at(int b, int a);
};

class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;
  // A copy has no factor: it is as new.
  SparseCholesky(const SparseCholesky&);
  SparseCholesky& operator=(const SparseCholesky&);

  // False when the matrix is not positive definite. `same_pattern`: the pattern is that of the last
  // call, and its symbolic analysis is used again.
  bool factor(const BlockMatrix& matrix, bool same_pattern);
  bool has_factor() const;

  // x with matrix x = b, one column of b at a time; needs a successful factor() before. These two
  // are for one thread at a time.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

  // y = L^-1 P b of matrix = P' L L' P: y'y = b' matrix^-1 b, the covariance of the linear
  // functions of x that are b's columns.
  Eigen::MatrixXd whiten(const Eigen::MatrixXd& b) const;

 private:
  struct Cholmod;
  std::unique_ptr<Cholmod> cholmod_;
};

}  // namespace eifmap
