#include "filter/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "support/random.h"

namespace eifmap::test {
namespace {

PoseBlock random_block(Random& random) {
  PoseBlock block;
  for (int e = 0; e < 36; ++e) block(e / 6, e % 6) = random.normal();
  return block;
}

void fill(BlockColumn& column, int a, Random& random) {
  for (std::size_t k = 0; k < column.row.size(); ++k) {
    column.block[k] = random_block(random);
    if (column.row[k] == a)
      column.block[k] =
          (column.block[k] * column.block[k].transpose() + 100 * PoseBlock::Identity()).eval();
    column.changed[k] = 1;
  }
}

// One pose more, that meets the three before it and, after the first lap, those of the lap before.
void add_pose(BlockMatrix& matrix, int lap, Random& random) {
  const int a = matrix.size();
  matrix.append();
  BlockColumn& column = matrix.write(a);
  for (int b = std::max(0, a - 3); b <= a; ++b) column.insert(b);
  for (int b = a - lap; b >= 0 && b < a - lap + 2; ++b) column.insert(b);
  fill(column, a, random);
}

// Positive definite.
BlockMatrix sample(int size, Random& random) {
  BlockMatrix matrix;
  while (matrix.size() < size) add_pose(matrix, 40, random);
  return matrix;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(6 * matrix.size(), 6 * matrix.size());
  for (int a = 0; a < matrix.size(); ++a) {
    const BlockColumn& column = matrix.column(a);
    for (std::size_t k = 0; k < column.row.size(); ++k) {
      full.block<6, 6>(6 * column.row[k], 6 * a) = column.block[k];
      full.block<6, 6>(6 * a, 6 * column.row[k]) = column.block[k].transpose();
    }
  }
  return full;
}

void expect_solves(const SparseCholesky& cholesky, const BlockMatrix& matrix) {
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(6 * matrix.size(), 3);
  const Eigen::MatrixXd expected = dense(matrix).ldlt().solve(b);
  EXPECT_LT((cholesky.solve(b) - expected).norm(), 1e-10 * expected.norm()) << matrix.size();
  const Eigen::MatrixXd white = cholesky.whiten(b);
  EXPECT_LT((white.transpose() * white - b.transpose() * expected).norm(),
            1e-10 * (b.transpose() * expected).norm());
}

TEST(SparseCholesky, HasTheInversesBlocksWhereTheMatrixHasAny) {
  Random random(7);
  for (int size : {1, 2, 20, 60, 150}) {
    SparseCholesky cholesky;
    const BlockMatrix matrix = sample(size, random);
    ASSERT_TRUE(cholesky.factor(matrix));
    const SelectedInverse selected = cholesky.selected_inverse();
    const Eigen::MatrixXd inverse = dense(matrix).inverse();
    for (int a = 0; a < size; ++a)
      for (const int b : matrix.column(a).row) {
        PoseBlock block;
        ASSERT_TRUE(selected.block(a, b, block));
        EXPECT_LT((block - inverse.block<6, 6>(6 * a, 6 * b)).norm(), 1e-10 * inverse.norm());
        ASSERT_TRUE(selected.block(b, a, block));
        EXPECT_LT((block - inverse.block<6, 6>(6 * b, 6 * a)).norm(), 1e-10 * inverse.norm());
      }
  }
}

TEST(SparseCholesky, SolvesAsADenseSolverDoes) {
  Random random(1);
  for (int size : {1, 2, 20, 60, 150}) {
    SparseCholesky cholesky;
    const BlockMatrix matrix = sample(size, random);
    ASSERT_TRUE(cholesky.factor(matrix));
    expect_solves(cholesky, matrix);
  }
}

// As a map does: poses come, some blocks change, old poses meet anew.
TEST(SparseCholesky, FollowsAMatrixThatGrowsAndChanges) {
  Random random(4);
  SparseCholesky cholesky;
  BlockMatrix matrix;
  Eigen::VectorXd right_side;
  int orders = 0, kept = 0;
  for (int step = 0; step < 140; ++step) {
    matrix.clear_changed();
    add_pose(matrix, 70, random);
    if (step % 3 == 0) fill(matrix.write(step / 2), step / 2, random);
    if (step % 10 == 9) {
      BlockColumn& column = matrix.write(step);
      const int at = column.insert(step / 3);
      column.block[at] = random_block(random);
      column.changed[at] = 1;
    }
    ASSERT_TRUE(cholesky.factor(matrix)) << step;
    orders += cholesky.was_ordered();
    kept += cholesky.num_nodes() - cholesky.num_factored();
    ASSERT_NO_FATAL_FAILURE(expect_solves(cholesky, matrix));

    // To the bit what factoring all of it gives.
    SparseCholesky whole = cholesky;
    for (int a = 0; a < matrix.size(); ++a) {
      BlockColumn& column = matrix.write(a);
      std::fill(column.changed.begin(), column.changed.end(), 1);
    }
    ASSERT_TRUE(whole.factor(matrix));
    EXPECT_EQ(whole.num_factored(), whole.num_nodes());
    const Eigen::MatrixXd b = Eigen::MatrixXd::Random(6 * matrix.size(), 1);
    EXPECT_EQ(cholesky.whiten(b), whole.whiten(b)) << step;
    // A right side of which a part is as it was in the last step.
    right_side.conservativeResize(b.rows());
    const Eigen::Index news = std::min<Eigen::Index>(b.rows(), 6 + 6 * (step % 7));
    right_side.tail(news) = b.topRows(news);
    if (step % 5 == 0) right_side.head(6) = b.bottomRows(6);
    const Eigen::VectorXd y = cholesky.whiten_column(right_side);
    EXPECT_EQ(y, whole.whiten_column(right_side)) << step;
    EXPECT_LT((y - cholesky.whiten(right_side)).norm(), 1e-12 * y.norm()) << step;
    const Eigen::VectorXd x = cholesky.solve_whitened(y);
    EXPECT_LT((x - cholesky.solve(right_side)).norm(), 1e-12 * x.norm()) << step;
  }
  EXPECT_GE(orders, 2);
  EXPECT_GT(kept, 500);
}

// A keyframe that meets only the latest ones costs the same in a long map as in a short one.
TEST(SparseCholesky, FactorsOnlyWhatANewPoseReaches) {
  Random random(6);
  SparseCholesky cholesky;
  BlockMatrix matrix = sample(30, random);
  ASSERT_TRUE(cholesky.factor(matrix));
  int most = 0;
  for (int step = 0; step < 300; ++step) {
    matrix.clear_changed();
    add_pose(matrix, 100000, random);
    ASSERT_TRUE(cholesky.factor(matrix));
    if (!cholesky.was_ordered()) most = std::max(most, cholesky.num_factored());
  }
  EXPECT_LE(most, 4);
  EXPECT_GT(cholesky.num_nodes(), 50);
}

TEST(SparseCholesky, ACopyGoesItsOwnWay) {
  Random random(7);
  BlockMatrix matrix = sample(50, random);
  SparseCholesky cholesky;
  ASSERT_TRUE(cholesky.factor(matrix));
  SparseCholesky copy = cholesky;
  const BlockMatrix before = matrix;
  matrix.clear_changed();
  fill(matrix.write(10), 10, random);
  ASSERT_TRUE(copy.factor(matrix));
  expect_solves(cholesky, before);
  expect_solves(copy, matrix);
}

TEST(SparseCholesky, SaysWhenTheMatrixIsNotPositiveDefinite) {
  Random random(2);
  BlockMatrix matrix = sample(5, random);
  matrix.write(4).block.back() *= -1;
  SparseCholesky cholesky;
  EXPECT_FALSE(cholesky.factor(matrix));
  EXPECT_FALSE(cholesky.has_factor());
  matrix.write(4).block.back() *= -1;
  ASSERT_TRUE(cholesky.factor(matrix));
  expect_solves(cholesky, matrix);
}

TEST(SparseCholesky, RefusesARightSideOfAnotherSize) {
  Random random(3);
  SparseCholesky cholesky;
  EXPECT_THROW(cholesky.solve(Eigen::MatrixXd::Zero(6, 1)), std::invalid_argument);
  ASSERT_TRUE(cholesky.factor(sample(2, random)));
  EXPECT_THROW(cholesky.solve(Eigen::MatrixXd::Zero(6, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
