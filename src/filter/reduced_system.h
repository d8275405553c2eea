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
#include "filter/landmark_set.h"
#include "filter/pose_blocks.h"
#include "filter/pose_index.h"

namespace eifmap {

// The gauge's seventh degree of freedom: the first baseline keeps its length along its first
// direction. Held as firmly as the conditioning allows, for the covariances count the scale as
// known.
struct ScaleGauge {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit, world
  double length = 0;                                     // map units; 0: the scale is not held
};

// rad, of each direction: as what earth's orientation counts as known before any position has come.
inline constexpr double kEarthPrior = 0.5;
// Map units and rad: as what is held by definition counts as known; covariances have this in them.
inline constexpr double kByDefinition = 1e-5;

// Over all poses but the first, which is the gauge, and earth_from_map where there is one.
class ReducedSystem {
 public:
  void set_gauge(const ScaleGauge& gauge);
  // Another unknown from now on, after so many poses.
  void append_earth(int num_poses) { blocks_.append_earth(num_poses); }
  // Where earth is, and its turn about this direction (unit, map), is by definition from now on; or
  // no longer.
  void hold_earth(const Eigen::Vector3d& up);
  void release_earth() { hold_earth(Eigen::Vector3d::Zero()); }
  const Eigen::Vector3d& held_up() const { return held_up_; }  // zero: not held
  const PoseBlocks& blocks() const { return blocks_; }

  // To be called before a measurement of the landmark, or the edge, is taken out.
  void before_removal(const FilterLandmark& landmark);
  void before_removal(const FilterEdge& edge);
  void before_removal(const FilterAbsolute& absolute);
  // Of a pose that nothing measures any more: its blocks with others go, and its own becomes the
  // unit matrix, so that it stays where it is and in nobody's way.
  void remove(int pose);
  // Takes the blocks of removed poses out where they are many, and says whether it has: then all
  // others have other numbers, and what was factored is of no use. What is summed stays summed.
  bool drop_removed(int num_poses);

  // Sums what has changed since the last call, and the right-hand side. `touched`: landmarks with
  // another measurement, linearization or residual than then, ascending; they have their Q, R
  // and step for still poses from then on. `baseline`: from the first pose to the second, at the
  // mean.
  void sum(const PoseIndex& index, FilterLandmarks& landmarks, const std::vector<int>& touched,
           FilterEdges& edges, std::vector<FilterAbsolute>& absolutes,
           const Eigen::Vector3d& baseline);

  // What was summed again since the last mark_factored() is marked as changed.
  const BlockMatrix& matrix() const { return matrix_; }
  void mark_factored() { matrix_.clear_changed(); }
  const Eigen::VectorXd& right_side() const { return right_side_; }
  // Sigmas, given the poses: of what the last sum() was told of, the landmark with most to go.
  double largest_step_alone() const { return largest_step_alone_; }
  int num_blocks_summed() const { return num_blocks_summed_; }  // in the last sum()

 private:
  void grow(int num_blocks);
  void mark(int pose, int other, bool may_insert);
  void mark_pairs(const FilterLandmark& landmark, bool may_insert);
  void mark_blocks(const FilterEdge& edge, bool may_insert);
  void mark_blocks(const FilterAbsolute& absolute, bool may_insert);
  void touch_right_side(int pose);
  void touch_right_side(const FilterAbsolute& absolute);
  void clear_stale_blocks(int a);
  void add_landmark(const FilterLandmark& landmark);
  void add_right_side(const FilterLandmark& landmark);
  void add_edge(const FilterEdge& edge);
  void add_absolute(const FilterAbsolute& absolute);
  void add_earth_prior();
  PoseBlock* stale_block(int i, int j);
  void add_gauge(const Eigen::Vector3d& baseline);

  PoseBlocks blocks_;
  Eigen::Vector3d held_up_ = Eigen::Vector3d::Zero();
  ScaleGauge gauge_;
  double gauge_weight_ = 0;
  BlockMatrix matrix_;
  std::vector<std::uint8_t> stale_column_, stale_side_;
  std::vector<std::uint8_t> removed_;  // by column
  int num_removed_ = 0;
  std::vector<BlockColumn*> stale_columns_;  // by column, within a sum
  LandmarkSet concerned_;
  Eigen::VectorXd right_side_;
  double largest_step_alone_ = 0;
  int num_blocks_summed_ = 0;
};

// Writes Q and R^-1 of the landmark's present linearization.
void factor_landmark(FilterLandmark& landmark);

// R times the step to its best place while its poses stand still: R V^-1 b.
Eigen::Vector3d step_alone_in_sigmas(const FilterLandmark& landmark);

// V^-1 of the present linearization: the feature's covariance given the poses. Zero when no
// sighting says anything, as behind all cameras.
Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark);

}  // namespace eifmap
