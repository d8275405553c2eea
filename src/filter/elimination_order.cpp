#include "filter/elimination_order.h"

#include <camd.h>
#include <cholmod.h>

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
    for (int b : matrix.column[a].row)
      if (b != a) neighbours[a].push_back(b), neighbours[b].push_back(a);
  Graph graph;
  graph.start.push_back(0);
  for (const std::vector<int>& of_one : neighbours) {
    graph.neighbour.insert(graph.neighbour.end(), of_one.begin(), of_one.end());
    graph.start.push_back(static_cast<int>(graph.neighbour.size()));
  }
  return graph;
}

std::vector<int> minimum_degree(const Graph& graph, int recent) {
  const int n = static_cast<int>(graph.start.size()) - 1;
  std::vector<int> constraint(static_cast<std::size_t>(n), 0), order(constraint);
  for (int p = std::max(0, n - recent); p < n; ++p) constraint[p] = 1;
  const int status = camd_order(n, graph.start.data(), graph.neighbour.data(), order.data(),
                                nullptr, nullptr, constraint.data());
  return status < 0 ? std::vector<int>() : order;
}

std::vector<int> nested_dissection(const Graph& graph) {
  const std::size_t n = graph.start.size() - 1;
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;  // a library never prints
  std::vector<int> order;
  // The lower triangle is left out: CHOLMOD takes the upper one of a symmetric matrix.
  cholmod_sparse* a =
      cholmod_allocate_sparse(n, n, graph.neighbour.size(), 1, 1, 1, CHOLMOD_PATTERN, &common);
  if (a != nullptr) {
    auto* start = static_cast<int*>(a->p);
    auto* row = static_cast<int*>(a->i);
    int next = 0;
    for (std::size_t c = 0; c < n; ++c) {
      start[c] = next;
      for (int k = graph.start[c]; k < graph.start[c + 1]; ++k)
        if (graph.neighbour[k] < static_cast<int>(c)) row[next++] = graph.neighbour[k];
      std::sort(row + start[c], row + next);
    }
    start[n] = next;
    order.resize(n);
    if (!cholmod_metis(a, nullptr, 0, 1, order.data(), &common)) order.clear();
  }
  cholmod_free_sparse(&a, &common);
  cholmod_finish(&common);
  return order;
}

}  // namespace

double elimination_cost(const BlockMatrix& matrix, const std::vector<int>& order) {
  EliminationTree tree;
  tree.set_order(order);
  tree.renew(matrix);
  return tree.cost();
}

std::vector<int> elimination_order(const BlockMatrix& matrix, int recent) {
  const int n = matrix.size();
  std::vector<int> best(static_cast<std::size_t>(n));
  std::iota(best.begin(), best.end(), 0);
  if (n <= recent) return best;
  double cost = elimination_cost(matrix, best);
  const Graph graph = graph_of(matrix);
  for (std::vector<int> order : {minimum_degree(graph, recent), nested_dissection(graph)}) {
    if (order.empty()) continue;
    std::stable_partition(order.begin(), order.end(), [&](int p) { return p < n - recent; });
    std::sort(order.end() - recent, order.end());
    const double other = elimination_cost(matrix, order);
    if (other >= cost) continue;
    cost = other;
    best = std::move(order);
  }
  return best;
}

}  // namespace eifmap
