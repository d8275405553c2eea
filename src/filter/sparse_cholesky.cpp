#include "filter/sparse_cholesky.h"

#include <dlfcn.h>

#include <algorithm>
#include <stdexcept>

#include "filter/elimination_order.h"

// BLAS and LAPACK, of the Fortran kind.
extern "C" {
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
            const double* beta, double* c, const int* ldc);
void dtrsm_(const char* side, const char* uplo, const char* transa, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}

namespace eifmap {
namespace {

// Poses whose measurements may still come or change; they are eliminated last.
constexpr int kRecent = 25;
// The order is sought again when the elimination costs so many times what growth explains.
constexpr double kCostlier = 1.4;

// A threaded OpenBLAS would sum in an order that depends on the number of cores, so it is held to
// one thread. The flavour that uses OpenMP keeps the limit by thread.
void pin_blas_to_one_thread() {
  thread_local const bool once = [] {
    using SetThreads = void (*)(int);
    if (auto* set = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads")))
      set(1);
    return true;
  }();
  static_cast<void>(once);
}

// For each node the ones before it whose next rows are its columns, as chains.
class Waiting {
 public:
  explicit Waiting(std::size_t num_nodes)
      : first_(num_nodes, -1), next_(num_nodes, -1), reached_(num_nodes, 0) {}
  int first(std::size_t node) const { return first_[node]; }
  int next(int waiting) const { return next_[waiting]; }
  int reached(int waiting) const { return reached_[waiting]; }  // its first row not used yet
  void wait(int waiting, int node, int reached) {
    reached_[waiting] = reached;
    next_[waiting] = first_[node];
    first_[node] = waiting;
  }

 private:
  std::vector<int> first_, next_, reached_;
};

using Panel = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

}  // namespace

void SparseCholesky::renew_tree(const BlockMatrix& matrix, int late) {
  was_ordered_ = false;
  if (tree_.size() == matrix.size() && num_blocks_ == matrix.num_blocks()) return;
  num_blocks_ = matrix.num_blocks();
  tree_.renew(matrix);
  const double growth =
      size_when_sought_ == 0 ? 0 : static_cast<double>(tree_.size()) / size_when_sought_;
  if (tree_.size() > kRecent && tree_.cost() > kCostlier * growth * cost_when_sought_) {
    std::vector<int> order = elimination_order(matrix, kRecent, late, tree_.order());
    was_ordered_ = order != tree_.order();
    if (was_ordered_) {
      tree_.set_order(std::move(order));
      tree_.renew(matrix);
    }
    cost_when_sought_ = tree_.cost();
    size_when_sought_ = tree_.size();
  }
}

// By position: whether a block that the factor's column there needs has changed.
std::vector<std::uint8_t> SparseCholesky::changed_positions(const BlockMatrix& matrix) const {
  std::vector<std::uint8_t> changed(static_cast<std::size_t>(tree_.size()), 0);
  for (const int a : matrix.written()) {
    const BlockColumn& column = matrix.column(a);
    for (std::size_t k = 0; k < column.row.size(); ++k)
      if (column.changed[k])
        changed[std::min(tree_.position(a), tree_.position(column.row[k]))] = 1;
  }
  return changed;
}

void SparseCholesky::assemble(Node& node, const BlockMatrix& matrix) {
  const int height = node.height();
  node.panel.assign(static_cast<std::size_t>(height) * node.columns() * kPoseDof, 0);
  for (int p = node.first; p <= node.last; ++p) place_[p] = (p - node.first) * kPoseDof;
  for (std::size_t r = 0; r < node.rows.size(); ++r)
    place_[node.rows[r]] = (node.columns() + static_cast<int>(r)) * kPoseDof;
  Eigen::Map<Eigen::MatrixXd> panel(node.panel.data(), height, node.columns() * kPoseDof);
  for (int p = node.first; p <= node.last; ++p) {
    for (const auto* e = tree_.entries_begin(p); e != tree_.entries_end(p); ++e) {
      const PoseBlock& block = matrix.column(e->column).block[e->index];
      auto into = panel.block<kPoseDof, kPoseDof>(place_[e->row], (p - node.first) * kPoseDof);
      if (e->transposed)
        into = block.transpose();
      else
        into = block;
    }
  }
}

// What the descendant's rows from `from`, of which those before `to` are the node's columns, take
// off the node's panel.
void SparseCholesky::take_off(const Node& descendant, int from, int to, Node& node) {
  const int lda = descendant.height(), k = descendant.columns() * kPoseDof;
  const int below = static_cast<int>(descendant.rows.size()) - from;
  const int m = below * kPoseDof, n = (to - from) * kPoseDof;
  const double* a = descendant.panel.data() + (descendant.columns() + from) * kPoseDof;
  product_.resize(std::max(product_.size(), static_cast<std::size_t>(m) * n));
  const double one = 1, zero = 0;
  dgemm_("N", "T", &m, &n, &k, &one, a, &lda, a, &lda, &zero, product_.data(), &m);
  const int height = node.height();
  for (int c = 0; c < to - from; ++c) {
    const int column = (descendant.rows[from + c] - node.first) * kPoseDof;
    for (int x = 0; x < kPoseDof; ++x) {
      const double* product = product_.data() + static_cast<std::size_t>(c * kPoseDof + x) * m;
      double* panel = node.panel.data() + static_cast<std::size_t>(column + x) * height;
      for (int r = c; r < below; ++r) {
        double* into = panel + place_[descendant.rows[from + r]];
        for (int y = 0; y < kPoseDof; ++y) into[y] -= product[r * kPoseDof + y];
      }
    }
  }
}

bool SparseCholesky::factor_panel(Node& node) {
  const int columns = node.columns() * kPoseDof, height = node.height();
  const int below = height - columns;
  int info = 0;
  dpotrf_("L", &columns, node.panel.data(), &height, &info);
  if (info != 0) return false;
  const double one = 1;
  if (below > 0)
    dtrsm_("R", "L", "T", "N", &below, &columns, &one, node.panel.data(), &height,
           node.panel.data() + columns, &height);
  return true;
}

bool SparseCholesky::factor(const BlockMatrix& matrix, int late) {
  pin_blas_to_one_thread();
  renew_tree(matrix, late);
  const std::vector<std::shared_ptr<const Node>> before = std::move(nodes_);
  nodes_.clear();
  num_factored_ = 0;
  const std::vector<Supernode>& supernodes = tree_.supernodes();
  std::vector<int> node_of(static_cast<std::size_t>(tree_.size()));
  for (std::size_t s = 0; s < supernodes.size(); ++s)
    for (int p = supernodes[s].first; p <= supernodes[s].last; ++p)
      node_of[p] = static_cast<int>(s);
  place_.resize(static_cast<std::size_t>(tree_.size()));
  Waiting waiting(supernodes.size());
  std::vector<std::uint8_t> fresh(supernodes.size(), 0);
  const std::vector<std::uint8_t> changed = changed_positions(matrix);
  const auto is_same = [&](const Node& node) {
    return node.rows == tree_.structure(node.last) &&
           std::find(changed.begin() + node.first, changed.begin() + node.last + 1, 1) ==
               changed.begin() + node.last + 1;
  };
  auto old = was_ordered_ ? before.end() : before.begin();
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    while (old != before.end() && (*old)->first < supernodes[s].first) ++old;
    bool stays = old != before.end() && (*old)->first == supernodes[s].first &&
                 (*old)->last == supernodes[s].last && is_same(**old);
    for (int d = waiting.first(s); stays && d >= 0; d = waiting.next(d)) stays = !fresh[d];
    std::shared_ptr<Node> node;
    if (!stays) {
      fresh[s] = 1;
      ++num_factored_;
      node = std::make_shared<Node>();
      node->first = supernodes[s].first;
      node->last = supernodes[s].last;
      node->rows = tree_.structure(node->last);
      assemble(*node, matrix);
    }
    for (int d = waiting.first(s); d >= 0;) {
      const int following = waiting.next(d);
      const std::vector<int>& rows = nodes_[d]->rows;
      const int from = waiting.reached(d);
      const auto beyond = std::upper_bound(rows.begin() + from, rows.end(), supernodes[s].last);
      const int to = static_cast<int>(beyond - rows.begin());
      if (node) take_off(*nodes_[d], from, to, *node);
      if (beyond != rows.end()) waiting.wait(d, node_of[*beyond], to);
      d = following;
    }
    if (node && !factor_panel(*node)) {
      nodes_.clear();
      return false;
    }
    nodes_.push_back(node ? std::move(node) : *old);
    const std::vector<int>& rows = nodes_.back()->rows;
    if (!rows.empty()) waiting.wait(static_cast<int>(s), node_of[rows.front()], 0);
  }
  return true;
}

template <class X>
X SparseCholesky::permuted(const X& b) const {
  if (!has_factor() || b.rows() != static_cast<Eigen::Index>(tree_.size()) * kPoseDof)
    throw std::invalid_argument("SparseCholesky: nothing of this size was factored");
  X x(b.rows(), b.cols());
  for (int p = 0; p < tree_.size(); ++p)
    x.template middleRows<kPoseDof>(p * kPoseDof) =
        b.template middleRows<kPoseDof>(tree_.pose(p) * kPoseDof);
  return x;
}

template <class X>
X SparseCholesky::unpermuted(const X& x) const {
  X result(x.rows(), x.cols());
  for (int p = 0; p < tree_.size(); ++p)
    result.template middleRows<kPoseDof>(tree_.pose(p) * kPoseDof) =
        x.template middleRows<kPoseDof>(p * kPoseDof);
  return result;
}

// Nodes in whose rows there are only zeros so far are passed over: a few poses' columns reach the
// root by a short way.
void SparseCholesky::solve_lower(Eigen::MatrixXd& x) const {
  Eigen::MatrixXd below;
  for (const auto& at : nodes_) {
    const Node& node = *at;
    const int columns = node.columns() * kPoseDof, height = node.height();
    auto top = x.middleRows(node.first * kPoseDof, columns);
    if ((top.array() == 0).all()) continue;
    const Panel panel(node.panel.data(), height, columns, Eigen::OuterStride<>(height));
    panel.topRows(columns).triangularView<Eigen::Lower>().solveInPlace(top);
    if (node.rows.empty()) continue;
    below.noalias() = panel.bottomRows(height - columns) * top;
    for (std::size_t r = 0; r < node.rows.size(); ++r)
      x.middleRows<kPoseDof>(node.rows[r] * kPoseDof) -=
          below.middleRows<kPoseDof>(static_cast<Eigen::Index>(r) * kPoseDof);
  }
}

template <class X>
void SparseCholesky::solve_upper(X& x) const {
  X below;
  for (auto at = nodes_.rbegin(); at != nodes_.rend(); ++at) {
    const Node* node = at->get();
    const int columns = node->columns() * kPoseDof, height = node->height();
    const Panel panel(node->panel.data(), height, columns, Eigen::OuterStride<>(height));
    auto top = x.middleRows(node->first * kPoseDof, columns);
    if (!node->rows.empty()) {
      below.resize(height - columns, x.cols());
      for (std::size_t r = 0; r < node->rows.size(); ++r)
        below.template middleRows<kPoseDof>(static_cast<Eigen::Index>(r) * kPoseDof) =
            x.template middleRows<kPoseDof>(node->rows[r] * kPoseDof);
      top.noalias() -= panel.bottomRows(height - columns).transpose() * below;
    }
    panel.topRows(columns).triangularView<Eigen::Lower>().transpose().solveInPlace(top);
  }
}

Eigen::MatrixXd SparseCholesky::whiten(const Eigen::MatrixXd& b) const {
  Eigen::MatrixXd x = permuted(b);
  solve_lower(x);
  return x;
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& b) const {
  Eigen::MatrixXd x = permuted(b);
  solve_lower(x);
  solve_upper(x);
  return unpermuted(x);
}

Eigen::VectorXd SparseCholesky::whiten_column(const Eigen::VectorXd& b) {
  Eigen::VectorXd y = permuted(b);
  whitened_.resize(static_cast<std::size_t>(tree_.size()));
  for (const auto& node : nodes_) {
    auto top = y.segment(node->first * kPoseDof, node->columns() * kPoseDof);
    std::shared_ptr<const Whitened>& last = whitened_[static_cast<std::size_t>(node->first)];
    if (!last || last->node != node || last->top != top) last = whiten_node(node, top);
    std::fill(whitened_.begin() + node->first + 1, whitened_.begin() + node->last + 1, nullptr);
    top = last->solved;
    for (std::size_t r = 0; r < node->rows.size(); ++r)
      y.segment<kPoseDof>(node->rows[r] * kPoseDof) -=
          last->below.segment<kPoseDof>(static_cast<Eigen::Index>(r) * kPoseDof);
  }
  return y;
}

auto SparseCholesky::whiten_node(const std::shared_ptr<const Node>& node,
                                 const Eigen::VectorXd& top) -> std::shared_ptr<const Whitened> {
  const int columns = node->columns() * kPoseDof, height = node->height();
  const Panel panel(node->panel.data(), height, columns, Eigen::OuterStride<>(height));
  auto done = std::make_shared<Whitened>();
  done->node = node;
  done->top = top;
  done->solved = panel.topRows(columns).triangularView<Eigen::Lower>().solve(top);
  done->below.noalias() = panel.bottomRows(height - columns) * done->solved;
  return done;
}

Eigen::VectorXd SparseCholesky::solve_whitened(const Eigen::VectorXd& y) const {
  Eigen::VectorXd x = y;
  solve_upper(x);
  return unpermuted(x);
}

}  // namespace eifmap
