// Absolute measurements, in metres, which give the map its scale: "any absolute measurement" in
// [WD10] IV. Of all kinds there are two models: the length of a way over points that are fixed to
// poses (a known distance is one over two), and a point's position in a frame of its own, "earth".
#pragma once

#include <Eigen/Core>
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
  enum class Kind { kLength, kPosition };
  Kind kind = Kind::kLength;
  // Of a length, 2 to kMostPoints, in the order of the way; of a position, one.
  std::vector<RigidPoint> points;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();           // m; of a length the first alone
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // m^2; of a length (0, 0) alone

  int rows() const { return kind == Kind::kLength ? 1 : 3; }
  static AbsoluteObservation length(std::vector<RigidPoint> points, double metres, double sigma);
  static AbsoluteObservation position(const RigidPoint& point, const Eigen::Vector3d& in_earth,
                                      const Eigen::Matrix3d& covariance);
};

// Rows of the measurement's derivative to one pose's (w, dc); beyond rows() zero. Of earth_from_map
// w is in the map's frame and dc in earth's.
struct PoseRows {
  int pose = 0;
  Eigen::Matrix<double, 3, 6> derivative = Eigen::Matrix<double, 3, 6>::Zero();
};

struct AbsoluteRows {
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();  // z - h, m; beyond rows() zero
  std::vector<PoseRows> of_pose;                       // each pose once
  double squared_derivative() const;
};

// At these poses; nothing is whitened. Where two points of a way coincide its derivative is taken
// as zero.
AbsoluteRows linearize(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                       const Rigid3& earth_from_map);

// L^-1 of the covariance L L', zero beyond rows(). False when it is not positive definite or not
// finite.
bool whitening(const AbsoluteObservation& observation, Eigen::Matrix3d& whiten);

}  // namespace eifmap
