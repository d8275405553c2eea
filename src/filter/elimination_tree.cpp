#include "filter/elimination_tree.h"

#include <algorithm>
#include <numeric>

namespace eifmap {
namespace {

// Columns of almost the same structure are stored as one panel, with zeros where they differ: dense
// arithmetic is faster by more than it has to do more.
constexpr int kMostColumns = 12;
constexpr double kMostZeros = 0.25;  // share of the panel
constexpr int kJoinedAnyway = 4;     // columns that are joined whatever the zeros

}  // namespace

void EliminationTree::set_order(std::vector<int> order) {
  order_ = std::move(order);
  position_.assign(order_.size(), 0);
  for (std::size_t p = 0; p < order_.size(); ++p)
    position_[static_cast<std::size_t>(order_[p])] = static_cast<int>(p);
  structure_ = {};
  num_entries_.clear();
}

void EliminationTree::collect_entries(const BlockMatrix& matrix) {
  const int n = matrix.size();
  start_.assign(static_cast<std::size_t>(n) + 1, 0);
  for (int a = 0; a < n; ++a)
    for (int b : matrix.column(a).row) ++start_[std::min(position_[a], position_[b]) + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  entries_.resize(static_cast<std::size_t>(start_.back()));
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (int a = 0; a < n; ++a) {
    const std::vector<int>& rows = matrix.column(a).row;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const int p = position_[rows[k]], q = position_[a];
      // The block is (p, q); the factor's column min(p, q) needs (max, min).
      entries_[next[std::min(p, q)]++] = {std::max(p, q), a, static_cast<int>(k), p < q};
    }
  }
}

void EliminationTree::grow_structure() {
  const auto n = order_.size();
  while (structure_.size() < n) structure_.push_back({});
  num_entries_.resize(n, 0);
  std::vector<std::vector<int>> children(n);
  std::vector<std::uint8_t> grown(n, 0);
  std::vector<int> marked(n, -1), rows;
  for (std::size_t j = 0; j < n; ++j) {
    const int entries = start_[j + 1] - start_[j];
    bool stale = entries != num_entries_[j];
    num_entries_[j] = entries;
    for (int c : children[j]) stale = stale || grown[static_cast<std::size_t>(c)];
    if (stale) {
      rows.clear();
      const auto add = [&](int row) {
        if (row <= static_cast<int>(j) || marked[row] == static_cast<int>(j)) return;
        marked[row] = static_cast<int>(j);
        rows.push_back(row);
      };
      for (int e = start_[j]; e < start_[j + 1]; ++e) add(entries_[e].row);
      for (int c : children[j])
        for (int row : structure_[static_cast<std::size_t>(c)]) add(row);
      std::sort(rows.begin(), rows.end());
      if (rows != structure_[j]) {
        structure_.write(j) = rows;
        grown[j] = 1;
      }
    }
    if (!structure_[j].empty())
      children[static_cast<std::size_t>(structure_[j].front())].push_back(static_cast<int>(j));
  }
}

void EliminationTree::find_supernodes() {
  supernodes_.clear();
  const int n = size();
  for (int first = 0; first < n;) {
    int last = first;
    double zeros = 0;
    while (last + 1 < n && last + 1 - first < kMostColumns && !structure_[last].empty() &&
           structure_[last].front() == last + 1) {
      const auto rows_now = static_cast<double>(structure_[last].size());
      const auto rows_then = static_cast<double>(structure_[last + 1].size());
      // Each column so far gets rows where only the new one has some.
      const int columns = last + 1 - first;
      const double more = zeros + columns * (rows_then + 1 - rows_now);
      const double panel = (columns + 1) * (rows_then + columns + 1);
      if (columns >= kJoinedAnyway && more > kMostZeros * panel) break;
      zeros = more;
      ++last;
    }
    supernodes_.push_back({first, last});
    first = last + 1;
  }
}

void EliminationTree::renew(const BlockMatrix& matrix) {
  for (int pose = size(); pose < matrix.size(); ++pose) {
    order_.push_back(pose);
    position_.push_back(pose);
  }
  collect_entries(matrix);
  grow_structure();
  find_supernodes();
}

double EliminationTree::cost() const {
  double sum = 0;
  for (const std::vector<int>& rows : structure_) {
    const auto r = static_cast<double>(rows.size());
    sum += (r + 1) * (r + 2) / 2;
  }
  return sum;
}

}  // namespace eifmap
