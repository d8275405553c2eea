// What the filter holds of each feature and each measurement.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "filter/measurement_models.h"

namespace eifmap {

// A feature seen from a pose.
struct PointMeasurement {
  int pose = 0;
  Eigen::Vector2d x = Eigen::Vector2d::Zero();  // normalized image coordinates
  double sigma = 0;                             // of x, each axis, same unit

  // Frozen at the last linearization; whitened, and scaled by the robust weight's root.
  bool linearized = false;
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  // at the linearization point
  double depth = 0;                                     // there
  Eigen::Matrix<double, 2, 6> d_pose = Eigen::Matrix<double, 2, 6>::Zero();
  Eigen::Matrix<double, 2, 3> d_landmark = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // what is left of z - h at the mean
  // This sight's rows of Q, where Q R is all the landmark's d_landmark, one above the other.
  Eigen::Matrix<double, 2, 3> q = Eigen::Matrix<double, 2, 3>::Zero();
};

struct FilterLandmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world
  // Given the poses, V^-1, as of the last update or promotion: a lower bound of the marginal.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<PointMeasurement> measurements;  // at most one per pose; empty: removed

  // A measurement has come, gone or been linearized since Q and R were computed.
  bool changed = true;
  // Of the frozen linearizations.
  Eigen::Matrix3d r_inverse = Eigen::Matrix3d::Zero();  // R^-1; V^-1 = R^-1 R^-T
  Eigen::Vector3d step = Eigen::Vector3d::Zero();       // to the best place while the poses stand
};

struct FilterEdge {
  int i = 0, j = 0;
  RelativePoseMeasurement measurement;
  bool linearized = false;
  // Scaled by the robust weight's root; the residual is what is left of z - h at the mean.
  RelativePoseLinearization linearization;
  // Whitened, without the weight: at the linearization point; squared, at the mean.
  Eigen::Matrix<double, 5, 1> residual_then = Eigen::Matrix<double, 5, 1>::Zero();
  double squared_error = 0;

  bool changed = true, moved = false;  // linearized, or another residual, since the last sum
};

// Which landmarks are seen from which pose.
class PoseIndex {
 public:
  void add_pose() { landmarks_.emplace_back(); }
  int num_poses() const { return static_cast<int>(landmarks_.size()); }
  const std::vector<int>& landmarks(int pose) const { return landmarks_[pose]; }  // ascending
  void add(int pose, int landmark);
  void remove(int pose, int landmark);

 private:
  std::vector<std::vector<int>> landmarks_;
};

// Some of the landmarks.
class LandmarkSet {
 public:
  void insert(int landmark) {
    if (static_cast<std::size_t>(landmark) >= in_.size()) in_.resize(landmark + 1, 0);
    if (in_[landmark]) return;
    in_[landmark] = 1;
    members_.push_back(landmark);
  }
  void clear() {
    for (int landmark : members_) in_[landmark] = 0;
    members_.clear();
  }
  // In the order of their handles.
  const std::vector<int>& sorted() {
    std::sort(members_.begin(), members_.end());
    return members_;
  }

 private:
  std::vector<std::uint8_t> in_;
  std::vector<int> members_;
};

}  // namespace eifmap
