// A sparse symmetric matrix of 6x6 blocks: the poses' information.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared_vector.h"

namespace eifmap {

inline constexpr int kPoseDof = 6;
using PoseBlock = Eigen::Matrix<double, kPoseDof, kPoseDof>;

// Blocks (b, a), b <= a, of one column a: of the upper triangle.
struct BlockColumn {
  std::vector<int> row;  // b, ascending; the last is a
  std::vector<PoseBlock> block;
  std::vector<std::uint8_t> changed;  // for SparseCholesky::factor(), by whoever summed them again
  std::vector<std::uint8_t> stale;    // for whoever sums them

  // Place of the block (b, a); -1: it is zero.
  int find(int b) const;
  // The same; makes a zero one where there is none, changed and stale.
  int insert(int b);
  void erase(int at);
};

// Copies share the columns that neither writes to.
class BlockMatrix {
 public:
  int size() const { return static_cast<int>(columns_.size()); }
  const BlockColumn& column(int a) const { return columns_[a]; }
  std::size_t num_blocks() const;

  BlockColumn& write(int a);
  void append() { columns_.push_back({}), is_written_.push_back(0); }
  // All columns with a changed block are among those that were written to since clear_changed().
  const std::vector<int>& written() const { return written_; }
  void clear_changed();
  // With its columns and rows in other places, -1: left out, ascending otherwise. All is changed.
  BlockMatrix renumbered(const std::vector<int>& now) const;

 private:
  SharedVector<BlockColumn, 2> columns_;
  std::vector<int> written_;
  std::vector<std::uint8_t> is_written_;  // by column
};

}  // namespace eifmap
