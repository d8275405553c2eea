// The information matrix with the features eliminated exactly: S = P - sum W V^-1 W', over the
// poses. Between updates few measurements are linearized again, so few blocks of S change: only
// those are summed again, each from nothing over all features that it is of. Nothing is ever
// subtracted, so no rounding piles up: S is to the bit what summing all of it would give.
// Features are eliminated by Q of their Jacobians' QR factorization, W V^-1 W' = (P'Q)(P'Q)' by
// rows (N. Demmel et al., Square Root Bundle Adjustment, CVPR 2021): V^-1 itself, of a point that
// is seen almost along one ray, is known to few digits, and S would not stay positive definite.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "filter/block_matrix.h"
#include "filter/filter_state.h"

namespace eifmap {

// The gauge's seventh degree of freedom: the first baseline keeps its length along its first
// direction. Held as firmly as the conditioning allows, for the covariances count the scale as
// known.
struct ScaleGauge {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit, world
  double length = 0;                                     // map units; 0: the scale is not held
};

// Pose p is block p - 1; pose 0 is the gauge and has none.
class ReducedSystem {
 public:
  void set_gauge(const ScaleGauge& gauge) { gauge_ = gauge; }

  // To be called before a measurement of the landmark, or the edge, is taken out.
  void before_removal(const FilterLandmark& landmark);
  void before_removal(const FilterEdge& edge);

  // Sums what has changed since the last call, and the right-hand side. `touched`: landmarks with
  // another measurement, linearization or residual than then, ascending; they have their Q, R
  // and step for still poses from then on. `baseline`: from the first pose to the second, at the
  // mean.
  void sum(const PoseIndex& index, std::vector<FilterLandmark>& landmarks,
           const std::vector<int>& touched, std::vector<FilterEdge>& edges,
           const Eigen::Vector3d& baseline);

  const BlockMatrix& matrix() const { return matrix_; }
  const Eigen::VectorXd& right_side() const { return right_side_; }
  int num_blocks_summed() const { return num_blocks_summed_; }  // in the last sum()

 private:
  void grow(int num_blocks);
  void mark(int pose, int other, bool may_insert);
  void mark_pairs(const FilterLandmark& landmark, bool may_insert);
  void mark_blocks(const FilterEdge& edge, bool may_insert);
  void touch_right_side(int pose);
  void sum_column(int a, const std::vector<int>& seen,
                  const std::vector<FilterLandmark>& landmarks);
  void sum_right_side(int a, const std::vector<int>& seen,
                      const std::vector<FilterLandmark>& landmarks);
  void add_edge(const FilterEdge& edge);
  void add_to_block(int i, int j, const PoseBlock& part);
  void add_gauge(const Eigen::Vector3d& baseline);

  ScaleGauge gauge_;
  double gauge_weight_ = 0;
  BlockMatrix matrix_;  // what the last sum() summed again is marked as changed
  // Before a sum: what it must sum again.
  std::vector<std::vector<std::uint8_t>> stale_;  // per column, parallel to its blocks
  std::vector<std::uint8_t> stale_column_, stale_side_;
  std::vector<int> slot_;  // of the column at hand: by row, the block's place; -1: not to be summed
  Eigen::VectorXd right_side_;
  int num_blocks_summed_ = 0;
};

// Writes Q and R^-1 of the landmark's present linearization: what it is eliminated by.
void factor_landmark(FilterLandmark& landmark);

// V^-1 of the present linearization: the feature's covariance given the poses. Zero when no
// sighting says anything, as behind all cameras.
Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark);

}  // namespace eifmap
