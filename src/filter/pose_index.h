// Which landmarks are seen from which pose.
#pragma once

#include <vector>

namespace eifmap {

class PoseIndex {
 public:
  void add_pose() { landmarks_.emplace_back(); }
  int num_poses() const { return static_cast<int>(landmarks_.size()); }
  const std::vector<int>& landmarks(int pose) const { return landmarks_[pose]; }  // ascending
  void add(int pose, int landmark);
  void remove(int pose, int landmark);

 private:
  std::vector<std::vector<int>> landmarks_;
};

}  // namespace eifmap
