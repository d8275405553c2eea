// The information matrix with the features eliminated exactly: S = P - sum W V^-1 W', over the poses.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/information_filter.h"

namespace eifmap {

// Which poses meet in S: those that share a feature or an edge. Pose p is block p - 1; pose 0 is the
// gauge and has none.
BlockMatrix reduced_pattern(int num_poses, const std::vector<FilterLandmark>& landmarks,
                            const std::vector<FilterEdge>& edges);

// Sums S and the right-hand side from the frozen linearizations. `matrix` has the pattern already.
void reduce(const std::vector<FilterLandmark>& landmarks, const std::vector<FilterEdge>& edges,
            BlockMatrix& matrix, Eigen::VectorXd& right_side);

// The gauge's seventh degree of freedom: holds pose 1 along the first baseline. No measurement says
// anything about the scale, so the weight does not matter beyond conditioning.
void add_scale_gauge(const Rigid3& pose0, const Rigid3& pose1, BlockMatrix& matrix);

// The feature's own step once the poses' is known: V^-1 (b - W' delta).
Eigen::Vector3d landmark_step(const FilterLandmark& landmark, const Eigen::VectorXd& delta_poses);

}  // namespace eifmap
