// The information matrix with the features eliminated exactly: S = P - sum W V^-1 W', over the
// poses. Between updates few measurements are linearized again, so few blocks of S change: only
// those are summed again, each from nothing over all features that it is of. Nothing is ever
// subtracted, so no rounding piles up: S is to the bit what summing all of it would give.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "filter/filter_state.h"
#include "filter/sparse_cholesky.h"

namespace eifmap {

// The gauge's seventh degree of freedom: the first baseline keeps its length along its first
// direction. Held as firmly as the conditioning allows, for the covariances count the scale as
// known.
struct ScaleGauge {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit, world
  double length = 1;                                     // map units
};

// Pose p is block p - 1; pose 0 is the gauge and has none.
class ReducedSystem {
 public:
  // To be called before a measurement of the landmark is taken out.
  void before_removal(const FilterLandmark& landmark);

  // Sums what the landmarks that have changed make different, and the right-hand side. They count
  // as unchanged from then on, and have their V^-1. `same_pattern`: no pose or measurement has come
  // or gone since the last call.
  void sum(int num_poses, std::vector<FilterLandmark>& landmarks,
           const std::vector<FilterEdge>& edges, bool same_pattern);
  // To be called after sum(). `baseline`: from the first pose to the second, at the mean.
  void add_scale_gauge(const ScaleGauge& gauge, const Eigen::Vector3d& baseline);

  const BlockMatrix& matrix() const { return matrix_; }
  const Eigen::VectorXd& right_side() const { return right_side_; }
  int num_blocks_summed() const { return num_blocks_summed_; }  // in the last sum()

 private:
  int slot(int b, int a) const { return slots_[slot_start_[a] + b]; }
  void renew_pattern(int num_poses, const std::vector<FilterLandmark>& landmarks,
                     const std::vector<FilterEdge>& edges);
  void index_slots();
  void mark(const FilterLandmark& landmark);
  void sum_blocks(const FilterLandmark& landmark);
  void add_edge(const FilterEdge& edge);

  BlockMatrix of_landmarks_;  // S without the edges, which are few and always linearized anew
  BlockMatrix matrix_;        // S
  std::vector<std::uint8_t> stale_;  // per block of of_landmarks_: to be summed again
  // Where the block (b, a), b <= a, is: slots_[slot_start_[a] + b]; -1: not in the pattern.
  std::vector<std::size_t> slot_start_;
  std::vector<int> slots_;
  Eigen::VectorXd right_side_;
  int num_blocks_summed_ = 0;
};

// V^-1 of the present linearization: the feature's covariance given the poses. Zero when no
// sighting says anything, as behind all cameras.
Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark);

}  // namespace eifmap
