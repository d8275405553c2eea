// What the filter holds of each feature and each measurement.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/absolute_observation.h"
#include "filter/measurement_models.h"

namespace eifmap {

// Of normalized image coordinates to the pose's (w, dc). Only the way from the centre to the point
// counts: to the point's displacement (world) it is the right half, negative.
using SightDerivative = Eigen::Matrix<double, 2, 6>;
inline auto to_landmark(const SightDerivative& d_pose) {
  return -d_pose.rightCols<3>();
}

// A feature seen from a pose.
struct PointMeasurement {
  int pose = 0;
  Eigen::Vector2d x = Eigen::Vector2d::Zero();  // normalized image coordinates
  double sigma = 0;                             // of x, each axis, same unit

  // Frozen at the last linearization; whitened, and scaled by the robust weight's root: what the
  // information is summed of.
  bool linearized = false;
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  // at the linearization point
  double depth = 0;                                     // there
  double root = 0;                                      // of the robust weight
  SightDerivative d_pose = SightDerivative::Zero();
  // Of the same weight, at the mean: what the gradient is summed of. A frozen one would pull at a
  // map that has turned or grown since.
  SightDerivative d_pose_now = SightDerivative::Zero();
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // what is left of z - h at the mean
};

// What a landmark's elimination takes off the poses' matrix: of the blocks of two poses that see
// it, rows' rows.
struct Elimination {
  int pose = 0;
  // Q'd_pose of the sight's rows of Q, where Q R is all the landmark's derivatives, one above the
  // other.
  Eigen::Matrix<double, 3, 6, Eigen::RowMajor> rows;
};

struct FilterLandmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world
  // Given the poses, V^-1, as of the last update or promotion: a lower bound of the marginal.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<PointMeasurement> measurements;  // at most one per pose; empty: removed

  // A measurement has come, gone or been linearized since what follows was computed.
  bool changed = true;
  std::vector<Elimination> eliminations;  // by measurement
  // Of the frozen linearizations.
  Eigen::Matrix3d r_inverse = Eigen::Matrix3d::Zero();  // R^-1; V^-1 = R^-1 R^-T
  Eigen::Vector3d step = Eigen::Vector3d::Zero();       // to the best place while the poses stand
};

struct FilterEdge {
  int i = 0, j = 0;
  RelativePoseMeasurement measurement;
  bool linearized = false;
  // As of a sight: the matrix is summed of the frozen derivatives, the gradient of those at the
  // mean. Scaled by the root of the robust weight.
  RelativePoseLinearization frozen, now;
  double root = 0;
  // Whitened, without the weight: at the linearization point; squared, at the mean.
  Eigen::Matrix<double, 5, 1> residual_then = Eigen::Matrix<double, 5, 1>::Zero();
  double squared_error = 0;

  bool changed = true, moved = false;  // linearized, or another residual, since the last sum
};

struct FilterAbsolute {
  AbsoluteObservation observation;
  Eigen::Matrix3d whiten = Eigen::Matrix3d::Zero();
  bool linearized = false;
  // As of an edge; whitened, and scaled by the root of what it weighs against sights
  // (InformationFilter::absolute_weight()).
  AbsoluteRows frozen, now;
  double squared_error = 0;  // at the mean; whitened, without the weight

  bool changed = true, moved = false;  // as of an edge
};

}  // namespace eifmap
