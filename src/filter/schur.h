// The information matrix with the features eliminated exactly: S = P - sum W V^-1 W', over the
// poses.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/filter_state.h"
#include "filter/sparse_cholesky.h"

namespace eifmap {

// Which poses meet in S: those that share a feature or an edge. Pose p is block p - 1; pose 0 is
// the gauge and has none.
BlockMatrix reduced_pattern(int num_poses, const std::vector<FilterLandmark>& landmarks,
                            const std::vector<FilterEdge>& edges);

// Sums S and the right-hand side from the frozen linearizations. `matrix` has the pattern already.
void reduce(const std::vector<FilterLandmark>& landmarks, const std::vector<FilterEdge>& edges,
            BlockMatrix& matrix, Eigen::VectorXd& right_side);

// The gauge's seventh degree of freedom: the first baseline keeps its length along its first
// direction. Held as firmly as the conditioning allows, for the covariances count the scale as
// known.
struct ScaleGauge {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit, world
  double length = 1;                                     // map units
};
void add_scale_gauge(const ScaleGauge& gauge, const Eigen::Vector3d& baseline, BlockMatrix& matrix,
                     Eigen::VectorXd& right_side);

// The feature's own step once the poses' is known: V^-1 (b - W' delta).
Eigen::Vector3d landmark_step(const FilterLandmark& landmark, const Eigen::VectorXd& delta_poses);

// V^-1: the feature's covariance given the poses.
Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark);

}  // namespace eifmap
