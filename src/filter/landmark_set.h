// Some of the landmarks.
#pragma once

#include <algorithm>
#include <vector>

namespace eifmap {

class LandmarkSet {
 public:
  // Whether it was not in.
  bool insert(int landmark) {
    if (static_cast<std::size_t>(landmark) >= in_.size()) in_.resize(landmark + 1, false);
    if (in_[landmark]) return false;
    in_[landmark] = true;
    members_.push_back(landmark);
    return true;
  }
  bool contains(int landmark) const {
    return static_cast<std::size_t>(landmark) < in_.size() && in_[landmark];
  }
  void clear() {
    for (int landmark : members_) in_[landmark] = false;
    members_.clear();
  }
  // In the order of their handles.
  const std::vector<int>& sorted() {
    std::sort(members_.begin(), members_.end());
    return members_;
  }

 private:
  std::vector<bool> in_;  // of all that there ever were
  std::vector<int> members_;
};

}  // namespace eifmap
