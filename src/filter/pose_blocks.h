// Which block of the poses' matrix is whose. Blocks come in the order of the poses, and what comes
// later is appended, so that what is factored stays; but for renumber().
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace eifmap {

// In the place of a pose's handle: the transform from the map into the frame that absolute
// positions are in (absolute_observation.h). It sees no landmarks.
inline constexpr int kEarthFromMap = -1;

// Pose 0 is the gauge and has no block. All that were there at the last renumber() are in a table;
// those after it have a block each, one after the other, earth_from_map among them when it came.
class PoseBlocks {
 public:
  // -1: none.
  int of(int pose) const {
    if (pose == kEarthFromMap) return earth_;
    if (pose < num_listed()) return block_of_[static_cast<std::size_t>(pose)];
    const int block = num_kept() + pose - num_listed();
    return block + static_cast<int>(earth_ >= num_kept() && block >= earth_);
  }
  int pose(int block) const {
    if (block == earth_) return kEarthFromMap;
    if (block < num_kept()) return pose_of_[static_cast<std::size_t>(block)];
    const int before = static_cast<int>(earth_ >= num_kept() && block > earth_);
    return block - before - num_kept() + num_listed();
  }
  int count(int num_poses) const {
    return num_kept() + num_poses - num_listed() + static_cast<int>(earth_ >= num_kept());
  }
  bool has_earth() const { return earth_ >= 0; }
  int earth() const { return earth_; }
  // After so many poses, 2 or more.
  void append_earth(int num_poses) { earth_ = count(num_poses); }

  // Of the blocks of so many poses, those that are removed (by block) are no more; the others keep
  // their order. Returns each block's new number, -1 of a removed one.
  std::vector<int> renumber(int num_poses, const std::vector<std::uint8_t>& removed) {
    const int n = count(num_poses);
    std::vector<int> now(static_cast<std::size_t>(n), -1), pose_of;
    std::vector<int> block_of(static_cast<std::size_t>(num_poses), -1);
    for (int b = 0; b < n; ++b) {
      if (removed[static_cast<std::size_t>(b)]) continue;
      now[static_cast<std::size_t>(b)] = static_cast<int>(pose_of.size());
      pose_of.push_back(pose(b));
      if (pose_of.back() != kEarthFromMap)
        block_of[static_cast<std::size_t>(pose_of.back())] = now[static_cast<std::size_t>(b)];
    }
    if (has_earth()) earth_ = now[static_cast<std::size_t>(earth_)];
    block_of_ = std::move(block_of);
    pose_of_ = std::move(pose_of);
    return now;
  }

 private:
  int num_listed() const { return static_cast<int>(block_of_.size()); }
  int num_kept() const { return static_cast<int>(pose_of_.size()); }

  std::vector<int> block_of_{-1};  // by pose
  std::vector<int> pose_of_;       // by block
  int earth_ = -1;                 // its block
};

}  // namespace eifmap
