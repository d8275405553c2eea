#include "map/loop_graph.h"

#include <algorithm>
#include <cmath>

namespace eifmap {
namespace {

// How firmly the landmarks that they share hold two keyframes to each other: each by a pixel, and
// by its depth as it is known over the baseline of the two.
PoseGraphEdge edge_between(const Map& map, int i, int j, int shared, double depth) {
  constexpr double kLeastBaseline = 0.1;  // of the depth: landmarks are of more than two keyframes
  const Rigid3 i_from_j = map.pose(i).inverse() * map.pose(j);
  PoseGraphEdge edge{i, j, Similarity::of(i_from_j)};
  const double sigma = map.radians_per_pixel() / std::sqrt(std::max(1, shared));
  const double baseline = std::max(i_from_j.translation.norm(), kLeastBaseline * depth);
  edge.sigma_rotation = sigma;
  edge.sigma_translation = sigma * depth;
  edge.sigma_scale = sigma * depth / baseline;
  return edge;
}

}  // namespace

PoseGraph graph_with_loop(const Map& map, const LoopFit& loop) {
  constexpr int kMostEdges = 6;   // of a keyframe to older ones
  constexpr int kFewShared = 15;  // landmarks: no edge, but for the one with most
  PoseGraph graph;
  std::vector<double> depths;
  for (int k = 0; k < map.num_keyframes(); ++k) {
    graph.nodes.push_back(Similarity::of(map.pose(k)));
    graph.held.push_back(k < 2 || map.is_removed(k));
    depths.push_back(map.is_removed(k) ? 0 : map.median_depth(k));
  }
  for (int k = 1, before = 0; k < map.num_keyframes(); ++k) {
    if (map.is_removed(k)) continue;
    const double depth = depths[k] > 0 ? depths[k] : 1;
    const std::vector<int> shared = map.num_shared(k);
    int edges = 0;
    for (int other : map.covisible(k, map.num_keyframes())) {
      if (other >= k || edges == kMostEdges || (edges > 0 && shared[other] < kFewShared)) continue;
      graph.edges.push_back(edge_between(map, other, k, shared[other], depth));
      ++edges;
    }
    if (edges == 0) graph.edges.push_back(edge_between(map, before, k, 1, depth));
    before = k;
  }
  PoseGraphEdge closing{loop.old, loop.newest,
                        Similarity::of(map.pose(loop.old)).inverse() * loop.world_from_newest};
  const double sigma =
      map.radians_per_pixel() / std::sqrt(std::max<std::size_t>(1, loop.sights.size()));
  closing.sigma_rotation = sigma;
  closing.sigma_translation = sigma * std::max(depths[loop.old], 1e-9);
  closing.sigma_scale = std::max(loop.sigma_log_scale, sigma);
  graph.edges.push_back(closing);
  return graph;
}

}  // namespace eifmap
