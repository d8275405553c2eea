// Which block of the poses' matrix is whose. Blocks are never renumbered, so that what is factored
// stays: what comes later is appended.
#pragma once

namespace eifmap {

// In the place of a pose's handle: the transform from the map into the frame that absolute
// positions are in (absolute_observation.h). It sees no landmarks.
inline constexpr int kEarthFromMap = -1;

// Pose 0 is the gauge and has no block; pose p is block p - 1, or p once earth_from_map has come
// before it.
class PoseBlocks {
 public:
  // -1: none.
  int of(int pose) const {
    if (pose == kEarthFromMap) return earth_;
    return pose - 1 + static_cast<int>(earth_ >= 0 && pose > earth_);
  }
  int pose(int block) const {
    if (block == earth_) return kEarthFromMap;
    return block + 1 - static_cast<int>(earth_ >= 0 && block > earth_);
  }
  int count(int num_poses) const { return num_poses - 1 + static_cast<int>(has_earth()); }
  bool has_earth() const { return earth_ >= 0; }
  int earth() const { return earth_; }
  // After so many poses, 2 or more.
  void append_earth(int num_poses) { earth_ = num_poses - 1; }

 private:
  int earth_ = -1;  // its block
};

}  // namespace eifmap
