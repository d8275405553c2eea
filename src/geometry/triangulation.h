// A point from several views.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/rigid3.h"

namespace eifmap {

struct Sighting {
  Rigid3 world_from_camera;
  Eigen::Vector2d x;  // normalized image coordinates
  double sigma = 0;   // each axis, same unit
};

struct TriangulatedPoint {
  bool valid = false;  // in front of all views, converged, information not singular
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       // world
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // given the poses
  double max_parallax = 0;          // rad, largest angle between two of the viewing rays
  double max_error = 0;             // largest whitened reprojection error (norm / sigma)
  double relative_depth_sigma = 0;  // sigma_Z / Z in the last view
};

// Linear start (midpoint of the two rays of largest parallax), then Gauss-Newton on the
// reprojection errors of all views. Needs >= 2 sightings.
TriangulatedPoint triangulate(std::span<const Sighting> sightings);

}  // namespace eifmap
