#include "filter/block_matrix.h"

#include <algorithm>

namespace eifmap {

// Rows are different integers up to a: so far from the end as b is from a, there is b or less.
// Mostly it is b, since poses meet those just before them.
int BlockColumn::find(int b) const {
  if (row.empty()) return -1;
  const int last = static_cast<int>(row.size()) - 1;
  const int guess = std::clamp(last - (row.back() - b), 0, last);
  if (row[guess] == b) return guess;
  const auto at = std::lower_bound(row.begin() + guess, row.end(), b);
  return at == row.end() || *at != b ? -1 : static_cast<int>(at - row.begin());
}

int BlockColumn::insert(int b) {
  const auto at = std::lower_bound(row.begin(), row.end(), b);
  const auto place = at - row.begin();
  if (at != row.end() && *at == b) return static_cast<int>(place);
  row.insert(at, b);
  block.insert(block.begin() + place, PoseBlock::Zero());
  changed.insert(changed.begin() + place, 1);
  stale.insert(stale.begin() + place, 1);
  return static_cast<int>(place);
}

void BlockColumn::erase(int at) {
  row.erase(row.begin() + at);
  block.erase(block.begin() + at);
  changed.erase(changed.begin() + at);
  stale.erase(stale.begin() + at);
}

std::size_t BlockMatrix::num_blocks() const {
  std::size_t n = 0;
  for (const BlockColumn& c : columns_) n += c.row.size();
  return n;
}

BlockColumn& BlockMatrix::write(int a) {
  if (!is_written_[a]) {
    is_written_[a] = 1;
    written_.push_back(a);
  }
  return columns_.write(a);
}

BlockMatrix BlockMatrix::renumbered(const std::vector<int>& now) const {
  BlockMatrix matrix;
  for (int a = 0; a < size(); ++a) {
    if (now[a] < 0) continue;
    matrix.append();
    BlockColumn& column = matrix.write(now[a]) = columns_[a];
    for (int& row : column.row) row = now[row];
    std::fill(column.changed.begin(), column.changed.end(), 1);
  }
  return matrix;
}

void BlockMatrix::clear_changed() {
  for (const int a : written_) {
    is_written_[a] = 0;
    BlockColumn& column = columns_.write(a);
    std::fill(column.changed.begin(), column.changed.end(), 0);
  }
  written_.clear();
}

}  // namespace eifmap
