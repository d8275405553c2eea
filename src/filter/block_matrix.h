// A sparse symmetric matrix of 6x6 blocks: the poses' information.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace eifmap {

inline constexpr int kPoseDof = 6;
using PoseBlock = Eigen::Matrix<double, kPoseDof, kPoseDof>;

// Blocks (b, a), b <= a, of one column a: of the upper triangle.
struct BlockColumn {
  std::vector<int> row;  // b, ascending; the last is a
  std::vector<PoseBlock> block;
  std::vector<std::uint8_t> changed;  // for SparseCholesky::factor(), by whoever summed them again

  // Place of the block (b, a); -1: it is zero.
  int find(int b) const;
  // The same; makes a zero one where there is none.
  int insert(int b);
};

struct BlockMatrix {
  std::vector<BlockColumn> column;

  int size() const { return static_cast<int>(column.size()); }
  std::size_t num_blocks() const;
  void clear_changed();
};

}  // namespace eifmap
