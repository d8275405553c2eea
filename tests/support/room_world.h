// Two rooms and a passage between them, among whose walls a camera is walked and carried: points
// with descriptors that never change, seen from near where no wall is between, so that from the one
// room nothing is seen of the other; without images.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "frame.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"

namespace eifmap::test {

struct RoomWorldOptions {
  double noise_px = 0.5;        // standard deviation of a keypoint's place, each axis
  double repeatability = 0.85;  // chance that a point in view gives a keypoint
  double wrong_share = 0.05;    // of the keypoints: they wear the descriptor of another
  // Of the wall that both rooms have opposite their door, the part that looks the same in both, and
  // stands the same.
  double alike = 0;
  int seed = 1;
};

// Camera as in notation.md; y is down. Room A is around the origin, room B around centre_of_b(),
// the passage leads from A to B along x. m.
class RoomWorld {
 public:
  explicit RoomWorld(const RoomWorldOptions& options = {});

  const Camera& camera() const { return camera_; }
  // In the middle of a room, on a circle that looks outwards: at angle 0 along x.
  static Rigid3 in_room(bool b, double angle);
  // From A's angle 0 to B's: 0 to 1. Or, looking back, from A's pi to B's.
  static Rigid3 on_the_way(double share, bool looks_back = false);
  static Eigen::Vector3d centre_of_b() { return {kApart, 0, 0}; }

  // What is seen from there, without time; `number` of all that is drawn for it.
  FeatureFrame frame(const Rigid3& world_from_camera, int number) const;

 private:
  static constexpr double kApart = 14;  // m, of the rooms' middles
  struct Point {
    Eigen::Vector3d place, faces;
    double size = 0;  // m
    int looks = 0;    // what its descriptor and sign come from
  };
  void add_wall(const Eigen::Vector3d& corner, const Eigen::Vector3d& along,
                const Eigen::Vector3d& faces);
  void repeat_walls();

  RoomWorldOptions options_;
  Camera camera_;
  std::vector<Point> points_;
};

}  // namespace eifmap::test
