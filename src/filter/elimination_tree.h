// Which blocks of the Cholesky factor are not zero, for an order of elimination; J. Liu, The role
// of elimination trees in sparse factorization, SIAM J. Matrix Anal. Appl. 11 (1990).
#pragma once

#include <vector>

#include "filter/block_matrix.h"

namespace eifmap {

// Columns first..last of the factor (positions), stored as one dense panel.
struct Supernode {
  int first = 0, last = 0;
  int columns() const { return last - first + 1; }
};

// Patterns grow only, so what a pattern's growth does not reach is kept.
class EliminationTree {
 public:
  // A block of the matrix as the factor's column needs it: (row, column) by position, row >=
  // column.
  struct Entry {
    int row = 0;                // position
    int column = 0, index = 0;  // in the matrix: matrix.column(column).block[index]
    bool transposed = false;    // that block is (column, row) by position
  };

  // `order`: poses by position. Forgets the structure of another order.
  void set_order(std::vector<int> order);
  // Poses beyond the order come last, as they are.
  void renew(const BlockMatrix& matrix);

  const std::vector<int>& order() const { return order_; }
  int size() const { return static_cast<int>(order_.size()); }
  int position(int pose) const { return position_[static_cast<std::size_t>(pose)]; }
  int pose(int position) const { return order_[static_cast<std::size_t>(position)]; }
  // Rows below the diagonal in the factor's column, ascending.
  const std::vector<int>& structure(int position) const {
    return structure_[static_cast<std::size_t>(position)];
  }
  const std::vector<Supernode>& supernodes() const { return supernodes_; }
  const Entry* entries_begin(int position) const { return entries_.data() + start_[position]; }
  const Entry* entries_end(int position) const { return entries_.data() + start_[position + 1]; }
  double cost() const;  // multiplications of the factorization, in blocks

 private:
  void collect_entries(const BlockMatrix& matrix);
  void grow_structure();
  void find_supernodes();

  std::vector<int> order_, position_;
  std::vector<int> start_;
  std::vector<Entry> entries_;
  std::vector<int> num_entries_;  // by position, as of the last call
  SharedVector<std::vector<int>, 8> structure_;
  std::vector<Supernode> supernodes_;
};

}  // namespace eifmap
