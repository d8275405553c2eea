#include "filter/elimination_order.h"

#include <camd.h>

#include <algorithm>
#include <numeric>

#include "filter/elimination_tree.h"

namespace eifmap {
namespace {

// The pattern without the diagonal, both triangles, in compressed columns.
struct Graph {
  std::vector<int> start, neighbour;
};

Graph graph_of(const BlockMatrix& matrix) {
  const auto n = static_cast<std::size_t>(matrix.size());
  std::vector<std::vector<int>> neighbours(n);
  for (int a = 0; a < matrix.size(); ++a)
    for (int b : matrix.column(a).row)
      if (b != a) neighbours[a].push_back(b), neighbours[b].push_back(a);
  Graph graph;
  graph.start.push_back(0);
  for (const std::vector<int>& of_one : neighbours) {
    graph.neighbour.insert(graph.neighbour.end(), of_one.begin(), of_one.end());
    graph.start.push_back(static_cast<int>(graph.neighbour.size()));
  }
  return graph;
}

std::vector<int> minimum_degree(const Graph& graph, int recent, int late) {
  const int n = static_cast<int>(graph.start.size()) - 1;
  std::vector<int> constraint(static_cast<std::size_t>(n), 0), order(constraint);
  if (late >= 0) constraint[late] = 1;
  for (int p = std::max(0, n - recent); p < n; ++p) constraint[p] = late >= 0 ? 2 : 1;
  const int status = camd_order(n, graph.start.data(), graph.neighbour.data(), order.data(),
                                nullptr, nullptr, constraint.data());
  return status < 0 ? std::vector<int>() : order;
}

}  // namespace

double elimination_cost(const BlockMatrix& matrix, const std::vector<int>& order) {
  EliminationTree tree;
  tree.set_order(order);
  tree.renew(matrix);
  return tree.cost();
}

std::vector<int> elimination_order(const BlockMatrix& matrix, int recent, int late,
                                   const std::vector<int>& present) {
  const int n = matrix.size();
  std::vector<int> best = present, own(static_cast<std::size_t>(n));
  std::iota(own.begin(), own.end(), 0);
  double cost = elimination_cost(matrix, present);
  for (std::vector<int> order : {own, minimum_degree(graph_of(matrix), recent, late)}) {
    if (order.empty()) continue;
    std::stable_partition(order.begin(), order.end(), [&](int p) { return p < n - recent; });
    if (late >= 0 && late < n - recent)
      std::stable_partition(order.begin(), order.end() - recent, [&](int p) { return p != late; });
    std::sort(order.end() - std::min(recent, n), order.end());
    const double other = elimination_cost(matrix, order);
    if (other >= cost) continue;
    cost = other;
    best = std::move(order);
  }
  return best;
}

}  // namespace eifmap
