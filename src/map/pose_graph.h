// Similarity transforms of keyframes that agree as well as they can with what is known of pairs of
// them: where a map that has drifted belongs once a loop is closed. The scale of each keyframe is
// an unknown, for that is what drifts: H. Strasdat, J. M. M. Montiel, A. J. Davison, Scale
// Drift-Aware Large Scale Monocular SLAM, RSS 2010.
#pragma once

#include <vector>

#include "geometry/similarity.h"

namespace eifmap {

// Node j seen from node i: i_from_j = world_from_i^-1 world_from_j.
struct PoseGraphEdge {
  int i = 0, j = 0;
  Similarity i_from_j;
  // Standard deviations of each axis of the rotation (rad), of each axis of the translation (units
  // of i) and of the scale's logarithm.
  double sigma_rotation = 1, sigma_translation = 1, sigma_scale = 1;
};

struct PoseGraph {
  std::vector<Similarity> nodes;  // world_from_node: where to start
  std::vector<char> held;         // by node: 1: stays where it is
  std::vector<PoseGraphEdge> edges;

  // Sum of squares of the edges' whitened errors at the nodes.
  double cost() const;
};

struct PoseGraphSolution {
  bool ok = false;  // else the graph cannot be solved: something hangs on nothing that is held
  int iterations = 0;
  double cost_before = 0, cost_after = 0;
};

// Moves the nodes to the least sum of squares, by Gauss-Newton steps that are damped where they do
// not lower it. Where not ok, the nodes are as they were. std::invalid_argument: an edge of a node
// that is none, or with a sigma that is not positive; as many `held` as nodes.
PoseGraphSolution solve(PoseGraph& graph, int max_iterations = 20);

}  // namespace eifmap
