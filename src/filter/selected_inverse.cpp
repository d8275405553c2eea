// Blocks of the inverse where the factor has any. With L = [A; B] of a supernode's columns, Y = B
// A^-1 and Z the inverse's blocks among the rows below, which come later in the order and are known
// when it is gone through backwards:
//
//   inverse below = -Z Y,   inverse of its own = (A A')^-1 - Y' (inverse below)
#include <algorithm>
#include <stdexcept>

#include "filter/sparse_cholesky.h"

namespace eifmap {
namespace {

using Panel = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

}  // namespace

int SelectedInverse::Node::row_of(int position) const {
  if (position >= first && position <= last) return (position - first) * kPoseDof;
  const auto row = std::lower_bound(rows.begin(), rows.end(), position);
  if (row == rows.end() || *row != position) return -1;
  return (last - first + 1 + static_cast<int>(row - rows.begin())) * kPoseDof;
}

bool SelectedInverse::block(int i, int j, PoseBlock& out) const {
  const int p = position_.at(static_cast<std::size_t>(i)),
            q = position_.at(static_cast<std::size_t>(j));
  const Node& node = nodes_[static_cast<std::size_t>(node_of_[std::min(p, q)])];
  const int row = node.row_of(std::max(p, q));
  if (row < 0) return false;
  out = node.inverse.block<kPoseDof, kPoseDof>(row, (std::min(p, q) - node.first) * kPoseDof);
  if (p < q) out.transposeInPlace();
  return true;
}

SelectedInverse SparseCholesky::selected_inverse() const {
  if (!has_factor()) throw std::invalid_argument("SparseCholesky: nothing was factored");
  SelectedInverse result;
  result.node_of_.resize(static_cast<std::size_t>(tree_.size()));
  for (int block = 0; block < tree_.size(); ++block)
    result.position_.push_back(tree_.position(block));
  for (const auto& node : nodes_) {
    for (int p = node->first; p <= node->last; ++p)
      result.node_of_[static_cast<std::size_t>(p)] = static_cast<int>(result.nodes_.size());
    result.nodes_.push_back({node->first, node->last, node->rows, {}});
  }
  Eigen::MatrixXd known, y;
  for (std::size_t s = nodes_.size(); s-- > 0;) {
    const Node& factor = *nodes_[s];
    SelectedInverse::Node& node = result.nodes_[s];
    const int columns = factor.columns() * kPoseDof, height = factor.height();
    const int below = height - columns;
    const Panel panel(factor.panel.data(), height, columns, Eigen::OuterStride<>(height));
    const auto own = panel.topRows(columns).triangularView<Eigen::Lower>();
    node.inverse.resize(height, columns);
    const Eigen::MatrixXd own_inverse = own.solve(Eigen::MatrixXd::Identity(columns, columns));
    node.inverse.topRows(columns).noalias() = own_inverse.transpose() * own_inverse;
    if (below == 0) continue;
    // Of the rows below among each other: lower blocks, from the nodes that they are columns of.
    known.resize(below, below);
    for (std::size_t c = 0; c < node.rows.size(); ++c) {
      const SelectedInverse::Node& of =
          result.nodes_[static_cast<std::size_t>(result.node_of_[node.rows[c]])];
      const int column = (node.rows[c] - of.first) * kPoseDof;
      const auto to = static_cast<Eigen::Index>(c) * kPoseDof;
      for (std::size_t r = c; r < node.rows.size(); ++r) {
        const int row = of.row_of(node.rows[r]);
        if (row < 0) throw std::logic_error("SparseCholesky: the factor's pattern is not closed");
        known.block<kPoseDof, kPoseDof>(static_cast<Eigen::Index>(r) * kPoseDof, to) =
            of.inverse.block<kPoseDof, kPoseDof>(row, column);
      }
    }
    y = panel.bottomRows(below);
    own.solveInPlace<Eigen::OnTheRight>(y);
    node.inverse.bottomRows(below).noalias() = -(known.selfadjointView<Eigen::Lower>() * y);
    node.inverse.topRows(columns).noalias() -= y.transpose() * node.inverse.bottomRows(below);
  }
  return result;
}

}  // namespace eifmap
