#include "filter/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "support/random.h"

namespace eifmap::test {
namespace {

// A positive definite block matrix in which block a meets a - 1 and, for some, an early one.
BlockMatrix sample(int size, Random& random) {
  BlockMatrix matrix;
  matrix.size = size;
  matrix.start.push_back(0);
  for (int a = 0; a < size; ++a) {
    if (a > 7 && a % 3 == 0) matrix.row.push_back(a - 7);
    if (a > 0) matrix.row.push_back(a - 1);
    matrix.row.push_back(a);
    matrix.start.push_back(static_cast<int>(matrix.row.size()));
  }
  matrix.block.resize(matrix.row.size());
  for (int a = 0; a < size; ++a)
    for (int k = matrix.start[a]; k < matrix.start[a + 1]; ++k) {
      for (int e = 0; e < 36; ++e) matrix.block[k](e / 6, e % 6) = random.normal();
      if (matrix.row[k] == a)
        matrix.block[k] =
            (matrix.block[k] * matrix.block[k].transpose() + 60 * PoseBlock::Identity()).eval();
    }
  return matrix;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(6 * matrix.size, 6 * matrix.size);
  for (int a = 0; a < matrix.size; ++a)
    for (int k = matrix.start[a]; k < matrix.start[a + 1]; ++k) {
      full.block<6, 6>(6 * matrix.row[k], 6 * a) = matrix.block[k];
      full.block<6, 6>(6 * a, 6 * matrix.row[k]) = matrix.block[k].transpose();
    }
  return full;
}

TEST(SparseCholesky, SolvesAsADenseSolverDoes) {
  Random random(1);
  SparseCholesky cholesky;
  for (int size : {1, 2, 20, 60}) {
    BlockMatrix matrix = sample(size, random);
    ASSERT_TRUE(cholesky.factor(matrix, false));
    // A second factorization with other values uses the first one's analysis.
    for (PoseBlock& block : matrix.block) block *= 1.5;
    ASSERT_TRUE(cholesky.factor(matrix, true));
    const Eigen::MatrixXd b = Eigen::MatrixXd::Random(6 * size, 3);
    const Eigen::MatrixXd expected = dense(matrix).ldlt().solve(b);
    EXPECT_LT((cholesky.solve(b) - expected).norm(), 1e-10 * expected.norm()) << size;
  }
}

TEST(SparseCholesky, SaysWhenTheMatrixIsNotPositiveDefinite) {
  Random random(2);
  BlockMatrix matrix = sample(5, random);
  matrix.at(4, 4) = -matrix.at(4, 4);
  SparseCholesky cholesky;
  EXPECT_FALSE(cholesky.factor(matrix, false));
}

TEST(SparseCholesky, RefusesARightSideOfAnotherSize) {
  Random random(3);
  SparseCholesky cholesky;
  EXPECT_THROW(cholesky.solve(Eigen::MatrixXd::Zero(6, 1)), std::invalid_argument);
  ASSERT_TRUE(cholesky.factor(sample(2, random), false));
  EXPECT_THROW(cholesky.solve(Eigen::MatrixXd::Zero(6, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
