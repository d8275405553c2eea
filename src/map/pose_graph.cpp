#include "map/pose_graph.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace eifmap {
namespace {

// Of a node: (w, dt, ds), R <- R Exp(w), t <- t + dt, log s <- log s + ds. Of an edge: rotation,
// translation, scale.
constexpr int kDof = 7;
using Error = Eigen::Matrix<double, kDof, 1>;
using Block = Eigen::Matrix<double, kDof, kDof>;

Error whitened_by(const PoseGraphEdge& edge) {
  Error weight;
  weight << Eigen::Vector3d::Constant(1 / edge.sigma_rotation),
      Eigen::Vector3d::Constant(1 / edge.sigma_translation), 1 / edge.sigma_scale;
  return weight;
}

// What the edge says less what the nodes say, whitened; `by_i`, `by_j`: its derivatives to them.
Error error_of(const PoseGraphEdge& edge, const Similarity& i, const Similarity& j,
               Block* by_i = nullptr, Block* by_j = nullptr) {
  const Similarity at = i.inverse() * j;
  const Eigen::Vector3d turned = so3_log(
      Eigen::Quaterniond(Eigen::Matrix3d(edge.i_from_j.rotation.transpose() * at.rotation)));
  const Error weight = whitened_by(edge);
  Error error;
  error << turned, at.translation - edge.i_from_j.translation,
      std::log(at.scale / edge.i_from_j.scale);
  if (by_i && by_j) {
    const Eigen::Matrix3d turn = so3_right_jacobian_inverse(turned);
    const Eigen::Matrix3d to_i = i.rotation.transpose() / i.scale;
    by_i->setZero();
    by_i->block<3, 3>(0, 0) = -turn * at.rotation.transpose();
    by_i->block<3, 3>(3, 0) = skew(at.translation);
    by_i->block<3, 3>(3, 3) = -to_i;
    by_i->block<3, 1>(3, 6) = -at.translation;
    (*by_i)(6, 6) = -1;
    by_j->setZero();
    by_j->block<3, 3>(0, 0) = turn;
    by_j->block<3, 3>(3, 3) = to_i;
    (*by_j)(6, 6) = 1;
    *by_i = weight.asDiagonal() * *by_i;
    *by_j = weight.asDiagonal() * *by_j;
  }
  return weight.asDiagonal() * error;
}

Similarity moved(const Similarity& node, const Error& step) {
  return {node.scale * std::exp(step(6)),
          nearest_rotation(node.rotation * so3_exp(step.head<3>()).toRotationMatrix()),
          node.translation + step.segment<3>(3)};
}

void check(const PoseGraph& graph) {
  const auto n = static_cast<int>(graph.nodes.size());
  if (graph.held.size() != graph.nodes.size())
    throw std::invalid_argument("PoseGraph: as many held flags as nodes");
  for (const PoseGraphEdge& e : graph.edges) {
    if (std::min(e.i, e.j) < 0 || std::max(e.i, e.j) >= n || e.i == e.j)
      throw std::invalid_argument("PoseGraph: an edge needs two nodes");
    if (!(e.sigma_rotation > 0 && e.sigma_translation > 0 && e.sigma_scale > 0 &&
          e.i_from_j.scale > 0))
      throw std::invalid_argument("PoseGraph: a sigma or a scale is not positive");
  }
}

// Whether each node hangs on one that is held.
bool hangs_together(const PoseGraph& graph) {
  std::vector<std::vector<int>> next(graph.nodes.size());
  for (const PoseGraphEdge& e : graph.edges) next[e.i].push_back(e.j), next[e.j].push_back(e.i);
  std::vector<char> reached = graph.held;
  std::vector<int> to_visit;
  for (std::size_t k = 0; k < reached.size(); ++k)
    if (reached[k]) to_visit.push_back(static_cast<int>(k));
  while (!to_visit.empty()) {
    const int at = to_visit.back();
    to_visit.pop_back();
    for (const int k : next[at])
      if (!reached[k]) reached[k] = 1, to_visit.push_back(k);
  }
  return std::all_of(reached.begin(), reached.end(), [](char r) { return r != 0; });
}

class Solver {
 public:
  explicit Solver(PoseGraph& graph) : graph_(graph), column_(graph.nodes.size(), -1) {
    for (std::size_t k = 0; k < column_.size(); ++k)
      if (!graph.held[k]) column_[k] = kDof * free_++;
  }
  int num_free() const { return free_; }

  void linearize() {
    triplets_.clear();
    gradient_ = Eigen::VectorXd::Zero(kDof * free_);
    for (const PoseGraphEdge& e : graph_.edges) {
      Block by[2];
      const Error error = error_of(e, graph_.nodes[e.i], graph_.nodes[e.j], &by[0], &by[1]);
      const int column[2] = {column_[e.i], column_[e.j]};
      for (int a = 0; a < 2; ++a) {
        if (column[a] < 0) continue;
        gradient_.segment<kDof>(column[a]) -= by[a].transpose() * error;
        for (int b = 0; b < 2; ++b)
          if (column[b] >= 0 && column[b] <= column[a])
            add(column[a], column[b], by[a].transpose() * by[b]);
      }
    }
  }

  // The step, with `damping` times the diagonal added to it.
  bool step(double damping, Eigen::VectorXd& delta) {
    Eigen::SparseMatrix<double> matrix(kDof * free_, kDof * free_);
    matrix.setFromTriplets(triplets_.begin(), triplets_.end());
    for (int k = 0; k < matrix.rows(); ++k) matrix.coeffRef(k, k) *= 1 + damping;
    if (!analyzed_) factor_.analyzePattern(matrix);
    analyzed_ = true;
    factor_.factorize(matrix);
    if (factor_.info() != Eigen::Success) return false;
    delta = factor_.solve(gradient_);
    return delta.allFinite();
  }

  std::vector<Similarity> after(const Eigen::VectorXd& delta) const {
    std::vector<Similarity> nodes = graph_.nodes;
    for (std::size_t k = 0; k < nodes.size(); ++k)
      if (column_[k] >= 0) nodes[k] = moved(nodes[k], delta.segment<kDof>(column_[k]));
    return nodes;
  }

 private:
  void add(int row, int column, const Block& block) {
    for (int r = 0; r < kDof; ++r)
      for (int c = 0; c < kDof; ++c)
        if (row + r >= column + c) triplets_.emplace_back(row + r, column + c, block(r, c));
  }

  PoseGraph& graph_;
  std::vector<int> column_;  // by node; -1: held
  int free_ = 0;
  std::vector<Eigen::Triplet<double>> triplets_;  // of the lower half
  Eigen::VectorXd gradient_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool analyzed_ = false;
};

}  // namespace

double PoseGraph::cost() const {
  double sum = 0;
  for (const PoseGraphEdge& e : edges) sum += error_of(e, nodes[e.i], nodes[e.j]).squaredNorm();
  return sum;
}

PoseGraphSolution solve(PoseGraph& graph, int max_iterations) {
  constexpr double kConverged = 1e-6;  // of the cost
  constexpr double kLeastDamping = 1e-6, kMostDamping = 1e3;
  check(graph);
  PoseGraphSolution solution;
  solution.cost_before = solution.cost_after = graph.cost();
  if (!hangs_together(graph)) return solution;
  const std::vector<Similarity> before = graph.nodes;
  Solver solver(graph);
  solution.ok = true;
  if (solver.num_free() == 0) return solution;
  double damping = 0;
  while (solution.iterations < max_iterations) {
    ++solution.iterations;
    solver.linearize();
    double cost = 0;
    std::vector<Similarity> nodes;
    Eigen::VectorXd delta;
    while (true) {
      if (!solver.step(damping, delta)) {
        graph.nodes = before;
        return {false, solution.iterations, solution.cost_before, solution.cost_before};
      }
      nodes = std::exchange(graph.nodes, solver.after(delta));
      cost = graph.cost();
      if (cost <= solution.cost_after) break;
      graph.nodes = nodes;
      damping = std::max(kLeastDamping, 10 * damping);
      if (damping > kMostDamping) return solution;
    }
    const double gained = solution.cost_after - cost;
    solution.cost_after = cost;
    damping = damping > kLeastDamping ? 0.1 * damping : 0;
    if (gained <= kConverged * solution.cost_after + 1e-12) break;
  }
  return solution;
}

}  // namespace eifmap
