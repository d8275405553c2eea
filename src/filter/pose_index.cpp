#include "filter/pose_index.h"

#include <algorithm>

namespace eifmap {

void PoseIndex::add(int pose, int landmark) {
  std::vector<int>& all = landmarks_.write(pose);
  const auto at = std::lower_bound(all.begin(), all.end(), landmark);
  if (at == all.end() || *at != landmark) all.insert(at, landmark);
}

void PoseIndex::remove(int pose, int landmark) {
  std::vector<int>& all = landmarks_.write(pose);
  const auto at = std::lower_bound(all.begin(), all.end(), landmark);
  if (at != all.end() && *at == landmark) all.erase(at);
  if (all.empty()) landmarks_.reset(pose);
}

}  // namespace eifmap
