// Lens models: normalized image coordinates n = (x/z, y/z) <-> the distorted ones of the sensor,
// pixel = focal length * distorted + principal point.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace eifmap::lens {

using Coefficients = std::array<double, 5>;

// Brown's radial-tangential model, OpenCV's order k1 k2 p1 p2 k3. Writes d(distorted)/d(n) when
// asked for.
Eigen::Vector2d distort_radial_tangential(const Coefficients& k, const Eigen::Vector2d& n,
                                          Eigen::Matrix2d* jacobian = nullptr);

// Equidistant fisheye (J. Kannala, S. Brandt, PAMI 2006; OpenCV's order k1 k2 k3 k4): a ray at the
// angle theta from the axis lands at the radius theta (1 + k1 theta^2 + ... + k4 theta^8).
Eigen::Vector2d distort_fisheye(const Coefficients& k, const Eigen::Vector2d& n,
                                Eigen::Matrix2d* jacobian = nullptr);

// The inverses, exact to rounding; of a lens that folds over, the branch that begins at the axis.
// Nothing where that branch does not reach, or for rays beyond kMaxViewAngle (camera.h).
std::optional<Eigen::Vector2d> undistort_radial_tangential(const Coefficients& k,
                                                           const Eigen::Vector2d& distorted);
std::optional<Eigen::Vector2d> undistort_fisheye(const Coefficients& k,
                                                 const Eigen::Vector2d& distorted);

// d(radius) / d(theta) of a fisheye; not above 0: the image folds over there.
double fisheye_slope(const Coefficients& k, double theta);

}  // namespace eifmap::lens
