// Cholesky factorization of a sparse symmetric matrix of 6x6 blocks, made anew only where it must
// be: a supernodal left-looking factorization (E. Ng and B. Peyton, SIAM J. Sci. Comput. 14, 1993)
// that keeps the panels that no change reaches. To the bit what factoring all of it in the same
// order gives. Copies share what they do not change.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "filter/block_matrix.h"
#include "filter/elimination_tree.h"

namespace eifmap {

// The blocks of the inverse that lie where the factor has any, all at once: K. Takahashi et al.,
// Formation of a sparse bus impedance matrix, PICA 1973, by supernodes. For about what two
// factorizations cost.
class SelectedInverse {
 public:
  // Blocks i and j of the matrix; false where the factor has none of that row and column.
  bool block(int i, int j, PoseBlock& out) const;

 private:
  friend class SparseCholesky;
  struct Node {
    int first = 0, last = 0;
    std::vector<int> rows;    // positions below, ascending
    Eigen::MatrixXd inverse;  // as a panel of the factor; its own rows are whole, not a triangle
    int row_of(int position) const;  // in `inverse`; -1: none
  };
  std::vector<int> position_;  // by block
  std::vector<int> node_of_;   // by position
  std::vector<Node> nodes_;
};

class SparseCholesky {
 public:
  // False when the matrix is not positive definite; there is no factor then. Blocks that are not
  // marked as changed must be as in the last call. The matrix may have grown by columns and blocks.
  // `late` (-1: none): a block that meets many others; it decides the order alone.
  bool factor(const BlockMatrix& matrix, int late = -1);
  bool has_factor() const { return !nodes_.empty(); }

  // x with matrix x = b, for each column of b; needs a successful factor() before.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

  // The same in halves, of one column: y = L^-1 P b, for which only what the last call did not
  // meet, in the factor or in b, is computed, to the same bits; and x = P' L'^-1 y.
  Eigen::VectorXd whiten_column(const Eigen::VectorXd& b);
  Eigen::VectorXd solve_whitened(const Eigen::VectorXd& y) const;

  // y = L^-1 P b of matrix = P' L L' P: y'y = b' matrix^-1 b, the covariance of the linear
  // functions of x that are b's columns.
  Eigen::MatrixXd whiten(const Eigen::MatrixXd& b) const;

  // Needs a successful factor() before.
  SelectedInverse selected_inverse() const;

  // Of the last factor(): supernodes, and those that were factored again.
  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  int num_factored() const { return num_factored_; }
  bool was_ordered() const { return was_ordered_; }

 private:
  // Columns of L: on top a lower triangle, its own rows; below the rows that it meets.
  struct Node {
    int first = 0, last = 0;    // positions
    std::vector<int> rows;      // positions below, ascending
    std::vector<double> panel;  // column by column
    int columns() const { return last - first + 1; }
    int height() const { return kPoseDof * (columns() + static_cast<int>(rows.size())); }
  };

  // What whiten_column() did with a node.
  struct Whitened {
    std::shared_ptr<const Node> node;
    Eigen::VectorXd top;     // as it came to the node
    Eigen::VectorXd solved;  // the part of y that belongs to the node's columns
    Eigen::VectorXd below;   // what that takes off the rows below
  };

  void renew_tree(const BlockMatrix& matrix, int late);
  std::vector<std::uint8_t> changed_positions(const BlockMatrix& matrix) const;
  void assemble(Node& node, const BlockMatrix& matrix);
  void take_off(const Node& descendant, int from, int to, Node& node);
  static bool factor_panel(Node& node);
  static std::shared_ptr<const Whitened> whiten_node(const std::shared_ptr<const Node>& node,
                                                     const Eigen::VectorXd& top);
  // Of Eigen::MatrixXd or, for which Eigen has faster ways, Eigen::VectorXd.
  template <class X>
  X permuted(const X& b) const;
  template <class X>
  X unpermuted(const X& x) const;
  void solve_lower(Eigen::MatrixXd& x) const;
  template <class X>
  void solve_upper(X& x) const;

  EliminationTree tree_;
  std::size_t num_blocks_ = 0;
  double cost_when_sought_ = 0;  // of the elimination, when an order was sought last
  int size_when_sought_ = 0;
  std::vector<std::shared_ptr<const Node>> nodes_;
  std::vector<std::shared_ptr<const Whitened>> whitened_;  // by the node's first position
  int num_factored_ = 0;
  bool was_ordered_ = false;
  std::vector<int> place_;       // of a position's block row in the panel at hand
  std::vector<double> product_;  // of two parts of a descendant
};

}  // namespace eifmap
