// A long recorded way among points with descriptors that never change: what a camera driven along
// it would see of walls on both sides, without images.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "consistency/frame_source.h"

namespace eifmap::test {

struct TrajectoryWorldOptions {
  int points_per_m = 24;  // of new ground
  double range = 50;      // m that one sees
  double noise_px = 0.5, noise_ratio = 1;
  double wrong_share = 0.05, repeatability = 0.85;
  int max_frames = 0;  // the first so many; 0: all
  // m along a straight way, after which everything looks the same again, and stands the same: 0
  // never.
  double period = 0;
  int seed = 1;
};

// A point is seen from where it faces alone: a place that is driven through the other way looks
// like another.
class TrajectoryWorld : public FrameSource {
 public:
  // 10 Hz. Throws std::runtime_error when the file (12 numbers a line: the first three rows of
  // world_from_camera; camera as in notation.md) cannot be read.
  TrajectoryWorld(const std::filesystem::path& file, const TrajectoryWorldOptions& options);
  // A straight way along z, of so many frames.
  explicit TrajectoryWorld(const TrajectoryWorldOptions& options);

  int size() const override { return static_cast<int>(poses_.size()); }
  const Camera& camera() const override { return camera_; }
  std::int64_t time_us(int i) const override { return 1'000'000 + 100'000 * std::int64_t{i}; }
  std::optional<Rigid3> world_from_camera(int i) const override {
    return poses_[static_cast<std::size_t>(i)];
  }
  FeatureFrame frame(int i) const override;
  int num_points() const { return static_cast<int>(points_.size()); }

 private:
  struct Point {
    Eigen::Vector3d place;
    Eigen::Vector3d faces;  // unit: the way that a camera looks which sees it
    double size = 0;        // m
    int looks = 0;          // what its descriptor and its sign come from
  };
  TrajectoryWorld(std::vector<Rigid3> poses, const TrajectoryWorldOptions& options);
  void make_points(const Rigid3& pose, double length);
  void make_periods();
  std::pair<int, int> cell(const Eigen::Vector3d& place) const;

  TrajectoryWorldOptions options_;
  Camera camera_;
  std::vector<Rigid3> poses_;
  std::vector<Point> points_;
  std::map<std::pair<int, int>, std::vector<int>> points_of_cell_;
};

}  // namespace eifmap::test
