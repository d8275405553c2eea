// What the filter holds of each feature and each measurement.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/absolute_observation.h"
#include "filter/measurement_models.h"
#include "geometry/projection.h"
#include "shared_vector.h"

namespace eifmap {

// Of normalized image coordinates to the pose's (w, dc). Only the way from the centre to the point
// counts: to the point's displacement (world) it is the right half, negative.
using SightDerivative = Eigen::Matrix<double, 2, 6>;

// A sight's derivatives, whitened and scaled by the robust weight's root. Of the pose's the left
// half is of where the point is seen and of nothing else, so it is not kept.
struct SightRows {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // prediction, normalized image coordinates
  Eigen::Matrix<double, 2, 3> to_landmark = Eigen::Matrix<double, 2, 3>::Zero();

  // `scale`: the weight's root over sigma.
  SightDerivative d_pose(double scale) const {
    SightDerivative d;
    d.leftCols<3>() = scale * derivative_to_turn(at);
    d.rightCols<3>() = -to_landmark;
    return d;
  }
};

// A feature seen from a pose.
struct PointMeasurement {
  Eigen::Vector2d x = Eigen::Vector2d::Zero();  // normalized image coordinates
  double sigma = 0;                             // of x, each axis, same unit
  int pose = 0;

  // Frozen at the last linearization; whitened, and scaled by the robust weight's root: what the
  // information is summed of.
  bool linearized = false;
  double depth = 0;  // at the linearization point
  double root = 0;   // of the robust weight
  double scale = 0;  // that over sigma, as they were there; 0: the sight says nothing
  SightRows frozen;
  // Of the same weight, at the mean: what the gradient is summed of. A frozen one would pull at a
  // map that has turned or grown since.
  SightRows now;
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // what is left of z - h at the mean
  // Rows of Q, where Q R is all the landmark's frozen derivatives, one above the other; as of its
  // last factorization.
  Eigen::Matrix<double, 2, 3> q = Eigen::Matrix<double, 2, 3>::Zero();

  SightDerivative d_pose() const { return frozen.d_pose(scale); }
  SightDerivative d_pose_now() const { return now.d_pose(scale); }
};

struct FilterLandmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // world
  // Given the poses, V^-1, as of the last update or promotion: a lower bound of the marginal.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<PointMeasurement> measurements;               // at most one per pose
  bool is_removed() const { return measurements.empty(); }  // or not measured yet

  // A measurement has come, gone or been linearized since what follows was computed.
  bool changed = true;
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

  bool stands() const { return linearized && !changed && !moved; }
};

struct FilterAbsolute {
  AbsoluteObservation observation;
  Eigen::Matrix3d whiten = Eigen::Matrix3d::Zero();  // of a distance of landmarks, with theirs
  bool linearized = false;
  // As of an edge; whitened, and scaled by the root of what it weighs against sights
  // (InformationFilter::absolute_weight()).
  AbsoluteRows frozen, now;
  double squared_error = 0;  // at the mean; whitened, without the weight

  bool changed = true, moved = false;  // as of an edge
  bool stands() const { return linearized && !changed && !moved; }
};

// Few become others with a keyframe.
using FilterLandmarks = SharedVector<FilterLandmark, 16>;
using FilterEdges = SharedVector<FilterEdge, 16>;

}  // namespace eifmap
