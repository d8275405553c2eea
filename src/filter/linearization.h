// When a measurement's derivatives are frozen anew at the mean.
//
// The matrix is summed of frozen derivatives, so that little of it changes; the gradient of those
// at the mean, so that what the filter settles at is the least-squares mean itself (of the robust
// weights as frozen), whatever is frozen. How far a derivative may be off is a question of
// convergence and of the covariances: the ways in which a long map bends or grows as a whole carry
// little information, and the errors of all sights together must stay far below it.
#pragma once

#include <vector>

#include "filter/filter_state.h"
#include "geometry/projection.h"
#include "geometry/rigid3.h"
#include "options.h"

namespace eifmap {

// How far a sight may move before it is linearized again.
struct Holding {
  double within = 0;    // of its prediction; normalized image coordinates
  double of_depth = 0;  // share of its depth: a point that is seen almost along one ray moves far
                        // while its image stays
  double turned = 0;    // rad, of its camera in the world
};

// Writes residual and derivatives at the mean, and freezes these where the sight has moved; says
// whether it did. Behind the camera the sight has no weight, until the outlier test takes it out.
// `huber_sigma`: whitened residual from which it counts less.
bool linearize(PointMeasurement& sight, const Projector& projector, const Eigen::Vector3d& point,
               const Holding& holding, double huber_sigma);

// The same of an edge between poses at the mean. `variance`: what its covariance is multiplied by.
void linearize(FilterEdge& edge, const Rigid3& world_from_i, const Rigid3& world_from_j,
               Relinearize when, double variance);

// The same of an absolute measurement that has moved or changed, by its rows at the mean, of the
// same poses as when it was frozen. `weight`: what its information is multiplied by.
void linearize(FilterAbsolute& absolute, AbsoluteRows at_mean, Relinearize when, double weight);

}  // namespace eifmap
