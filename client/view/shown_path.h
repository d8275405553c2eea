// The published positions of one map, as the pages have them: bounded, thinned where it grows long.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace eifmap {

class ShownPath {
 public:
  struct Step {
    Eigen::Vector3f position;  // map units, the camera's centre
    bool joined = true;        // to the step before; false where tracking was lost between them
  };

  // Past this every second step goes, and with it a half of the detail.
  static constexpr std::size_t kMaxSteps = 1 << 16;

  void add(const Eigen::Vector3d& position);
  // Of all steps so far: their unit is another now.
  void scale_by(double factor);
  void interrupt() { joined_ = false; }
  void clear();

  const std::vector<Step>& steps() const { return steps_; }
  // The first step that pages do not have yet, as of the last mark_sent().
  std::size_t first_unsent() const { return sent_; }
  bool changed() const { return changed_; }
  void mark_sent();

 private:
  void thin();

  std::vector<Step> steps_;
  std::size_t sent_ = 0;
  bool joined_ = false;
  bool changed_ = false;
};

}  // namespace eifmap
