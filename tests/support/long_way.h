// A long way of keyframes past points: what a filter is given of thousands of keyframes, without
// images. The camera looks where it goes.
#pragma once

#include <vector>

#include "filter/information_filter.h"
#include "geometry/projection.h"
#include "support/random.h"

namespace eifmap::test {

struct LongWayOptions {
  double points_per_pose = 50;
  double nearest = 3, farthest = 9;  // m, of a point from the pose it is made for
  double range = 10;                 // m, beyond which points are not seen
  double field = 0.65;               // half the image's width, normalized image coordinates
  double pixel = 1.0 / 600;          // rad
  double noise_px = 1;
  std::uint64_t seed = 1;
};

struct PointSight {
  int point = 0;
  Eigen::Vector2d x;  // with noise; normalized image coordinates
};

struct LongWay {
  LongWayOptions options;
  std::vector<Rigid3> poses;                    // true
  std::vector<Eigen::Vector3d> points;          // true
  std::vector<std::vector<PointSight>> sights;  // by pose
  std::size_t num_sights() const;
};

LongWay make_long_way(std::vector<Rigid3> poses, const LongWayOptions& options);

// Poses a step (m) apart on a round course that is gone round again from its end on.
std::vector<Rigid3> round_course(int num_poses, int poses_a_lap, double step = 0.8);

// Gives the filter pose by pose what the world shows of it. A point enters with its third sight.
class LongWayFeed {
 public:
  LongWayFeed(const LongWay& world, const FilterOptions& options);

  // Adds the next pose, from where the one before is now by the true motion, with its sights.
  // The caller updates.
  void add_next();
  int num_poses() const { return filter_.num_poses(); }
  bool done() const { return num_poses() == static_cast<int>(world_.poses.size()); }
  InformationFilter& filter() { return filter_; }

 private:
  struct Point {
    int landmark = -1;
    std::vector<std::pair<int, Eigen::Vector2d>> sights;  // pose, x: before it has entered
  };
  void enter(Point& point, int index);

  const LongWay& world_;
  InformationFilter filter_;
  Random random_;
  std::vector<Point> points_;
};

}  // namespace eifmap::test
