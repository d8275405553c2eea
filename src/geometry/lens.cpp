#include "geometry/lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/camera.h"

namespace eifmap::lens {
namespace {

double fisheye_radius(const Coefficients& k, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

// Smallest theta in [0, kMaxViewAngle] with the given radius: bracketed from the axis outwards, so
// that it is on the first branch, then Newton, held inside the bracket by bisection.
std::optional<double> fisheye_angle(const Coefficients& k, double radius) {
  constexpr int kSections = 16;
  double low = 0, high = 0;
  for (int i = 1; i <= kSections && !(fisheye_radius(k, high) >= radius); ++i) {
    low = high;
    high = kMaxViewAngle * i / kSections;
  }
  if (!(fisheye_radius(k, high) >= radius)) return std::nullopt;
  double theta = 0.5 * (low + high);
  for (int i = 0; i < 60; ++i) {
    const double error = fisheye_radius(k, theta) - radius;
    (error < 0 ? low : high) = theta;
    double next = theta - error / fisheye_slope(k, theta);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double change = std::abs(next - theta);
    theta = next;
    if (change < 1e-15) break;
  }
  return theta;
}

}  // namespace

Eigen::Vector2d distort_radial_tangential(const Coefficients& k, const Eigen::Vector2d& n,
                                          Eigen::Matrix2d* jacobian) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double p1 = k[2], p2 = k[3];
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  if (jacobian) {
    const double twice_slope = 2 * (k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]));  // d(radial) / d(r2)
    const double mixed = x * y * twice_slope + 2 * (p1 * x + p2 * y);
    *jacobian << radial + x * x * twice_slope + 2 * p1 * y + 6 * p2 * x, mixed,  //
        mixed, radial + y * y * twice_slope + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

Eigen::Vector2d distort_fisheye(const Coefficients& k, const Eigen::Vector2d& n,
                                Eigen::Matrix2d* jacobian) {
  const double r = n.norm(), theta = std::atan(r);
  if (r < 1e-9) {  // the model is the identity to far below rounding
    if (jacobian) jacobian->setIdentity();
    return n;
  }
  const double scale = fisheye_radius(k, theta) / r;
  if (jacobian) {
    const double outwards = fisheye_slope(k, theta) / (1 + r * r);  // d(theta) / dr = 1 / (1 + r^2)
    *jacobian =
        scale * Eigen::Matrix2d::Identity() + (outwards - scale) / (r * r) * n * n.transpose();
  }
  return scale * n;
}

double fisheye_slope(const Coefficients& k, double theta) {
  const double t2 = theta * theta;
  return 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
}

std::optional<Eigen::Vector2d> undistort_radial_tangential(const Coefficients& k,
                                                           const Eigen::Vector2d& distorted) {
  // Newton from the axis; a step that would leave the branch or gain nothing is halved.
  Eigen::Vector2d n = Eigen::Vector2d::Zero();
  Eigen::Matrix2d jacobian, next_jacobian;
  Eigen::Vector2d error = distort_radial_tangential(k, n, &jacobian) - distorted;
  for (int i = 0; i < 100 && error.squaredNorm() > 1e-28; ++i) {
    Eigen::Vector2d step = -(jacobian.inverse() * error);
    bool better = false;
    for (int halving = 0; halving < 40 && !better; ++halving) {
      const Eigen::Vector2d next = n + step;
      const Eigen::Vector2d next_error =
          distort_radial_tangential(k, next, &next_jacobian) - distorted;
      better = next_error.squaredNorm() < error.squaredNorm() && next_jacobian.determinant() > 0;
      if (better) n = next, error = next_error, jacobian = next_jacobian;
      step *= 0.5;
    }
    if (!better) break;  // rounding, or no such ray
  }
  const bool found = error.norm() < 1e-10 && n.norm() <= std::tan(kMaxViewAngle);
  return found ? std::optional(n) : std::nullopt;
}

std::optional<Eigen::Vector2d> undistort_fisheye(const Coefficients& k,
                                                 const Eigen::Vector2d& distorted) {
  const double radius = distorted.norm();
  if (radius < 1e-9) return distorted;
  const std::optional<double> theta = fisheye_angle(k, radius);
  if (!theta) return std::nullopt;
  return std::tan(*theta) / radius * distorted;
}

}  // namespace eifmap::lens
