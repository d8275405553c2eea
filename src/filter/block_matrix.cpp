#include "filter/block_matrix.h"

#include <algorithm>

namespace eifmap {

int BlockColumn::find(int b) const {
  const auto at = std::lower_bound(row.begin(), row.end(), b);
  return at == row.end() || *at != b ? -1 : static_cast<int>(at - row.begin());
}

int BlockColumn::insert(int b) {
  const auto at = std::lower_bound(row.begin(), row.end(), b);
  const auto place = at - row.begin();
  if (at != row.end() && *at == b) return static_cast<int>(place);
  row.insert(at, b);
  block.insert(block.begin() + place, PoseBlock::Zero());
  changed.insert(changed.begin() + place, 1);
  return static_cast<int>(place);
}

std::size_t BlockMatrix::num_blocks() const {
  std::size_t n = 0;
  for (const BlockColumn& c : column) n += c.row.size();
  return n;
}

void BlockMatrix::clear_changed() {
  for (BlockColumn& c : column) std::fill(c.changed.begin(), c.changed.end(), 0);
}

}  // namespace eifmap
