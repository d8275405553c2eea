// Absolute measurements, in metres, which give the map its scale: "any absolute measurement" in
// [WD10] IV; and gravity's direction, which levels it. The models: the length of a way over points
// that are fixed to poses (a known distance is one over two), a point's position in a frame of its
// own, "earth", which way is down in it (against its z axis), and the distance of two landmarks
// (landmark_distance.h).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "filter/pose_blocks.h"
#include "geometry/rigid3.h"

namespace eifmap {

// A point that moves with a pose: an antenna, or another frame's centre as it is seen from there.
struct RigidPoint {
  int pose = 0;
  Eigen::Vector3d in_pose;  // of the pose's camera frame; map units

  RigidPoint(int of, const Eigen::Vector3d& place = Eigen::Vector3d::Zero())
      : pose(of), in_pose(place) {}
};

inline constexpr int kMostPoints = 50;  // of a way: each meets all others in the matrix

struct AbsoluteObservation {
  enum class Kind { kLength, kPosition, kDown, kLandmarks };
  Kind kind = Kind::kLength;
  // Of a length, 2 to kMostPoints, in the order of the way; of a position and of down, one.
  std::vector<RigidPoint> points;
  std::array<int, 2> landmarks = {-1, -1};  // handles
  // m; of lengths the first alone. Of down, without unit: the unit vector in the camera's frame.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  // m^2; of lengths (0, 0) alone. Of down the upper left 2x2, rad^2, along tangents_of(value).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();

  int rows() const;  // degrees of freedom
  bool is_length() const { return kind == Kind::kLength || kind == Kind::kLandmarks; }
  static AbsoluteObservation length(std::vector<RigidPoint> points, double metres, double sigma);
  static AbsoluteObservation position(const RigidPoint& point, const Eigen::Vector3d& in_earth,
                                      const Eigen::Matrix3d& covariance);
  // `direction`: in the camera's frame, of any length but zero. `covariance`: of a turn (rotation
  // vector, camera's frame), rad^2; the part about the direction itself does not matter.
  static AbsoluteObservation down(int pose, const Eigen::Vector3d& direction,
                                  const Eigen::Matrix3d& covariance);
  static AbsoluteObservation distance(int landmark, int other, double metres, double sigma);
};

// Two unit vectors, the rows, at right angles to this one and to each other.
Eigen::Matrix<double, 2, 3> tangents_of(const Eigen::Vector3d& direction);

// Rows of the measurement's derivative to one pose's (w, dc); beyond rows() zero. Of earth_from_map
// w is in the map's frame and dc in earth's.
struct PoseRows {
  int pose = 0;
  Eigen::Matrix<double, 3, 6> derivative = Eigen::Matrix<double, 3, 6>::Zero();
};

struct AbsoluteRows {
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();  // z - h, m or rad; beyond rows() zero
  std::vector<PoseRows> of_pose;                       // each pose once
  double squared_derivative() const;
  PoseRows& of(int pose);  // makes them where there are none
};

// At these poses; nothing is whitened. Where two points of a way coincide its derivative is taken
// as zero. Not of a distance of landmarks, whose places it cannot know: std::invalid_argument.
AbsoluteRows linearize(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                       const Rigid3& earth_from_map);

// L^-1 of the covariance L L', zero beyond rows(). False when it is not positive definite or not
// finite.
bool whitening(const AbsoluteObservation& observation, Eigen::Matrix3d& whiten);

}  // namespace eifmap
