// Which landmarks are seen from which pose.
#pragma once

#include <vector>

#include "shared_vector.h"

namespace eifmap {

class PoseIndex {
 public:
  void add_pose() { landmarks_.push_back({}); }
  int num_poses() const { return static_cast<int>(landmarks_.size()); }
  const std::vector<int>& landmarks(int pose) const { return landmarks_[pose]; }  // ascending
  void add(int pose, int landmark);
  void remove(int pose, int landmark);

 private:
  SharedVector<std::vector<int>, 4> landmarks_;
};

}  // namespace eifmap
