#include "motion/epipolar_geometry.h"

#include <cmath>

#include "geometry/rigid3.h"

namespace eifmap {

EpipolarGeometry::EpipolarGeometry(const RelativePose& pose)
    : r_(pose.i_from_j.toRotationMatrix()),
      t_(pose.direction),
      basis_(sphere_basis(pose.direction)) {}

EpipolarGeometry::Lines EpipolarGeometry::lines_of(const Correspondence& match) const {
  Lines l;
  l.x_i = match.x_i.homogeneous();
  l.x_j = match.x_j.homogeneous();
  l.y = r_ * l.x_j;
  l.in_i = t_.cross(l.y);
  l.in_j = r_.transpose() * l.x_i.cross(t_);
  l.variance_i = match.sigma_i * match.sigma_i;
  l.variance_j = match.sigma_j * match.sigma_j;
  l.variance =
      l.variance_i * l.in_i.head<2>().squaredNorm() + l.variance_j * l.in_j.head<2>().squaredNorm();
  return l;
}

double EpipolarGeometry::residual(const Correspondence& match,
                                  Eigen::Matrix<double, 1, 5>* jacobian) const {
  const Lines l = lines_of(match);
  if (!(l.variance > 0)) {  // both points on the epipoles: the match says nothing
    if (jacobian) jacobian->setZero();
    return 0;
  }
  const double algebraic = l.x_i.dot(l.in_i);
  const double inverse_sigma = 1 / std::sqrt(l.variance);
  if (jacobian) {
    // d(a / sqrt(v)) = (da - (a / v) dv / 2) / sqrt(v), where with R <- R Exp(w), t <- t + B ab
    //   y moves by R (w x x_j), the line in i by dt x y + t x dy,
    //   the line in j by (line in j) x w + R' (x_i x dt);
    // da and dv are linear in those, so they are contracted from the left.
    const double ratio = algebraic / l.variance;
    const Eigen::Vector3d dv_i(l.variance_i * l.in_i.x(), l.variance_i * l.in_i.y(), 0);
    const Eigen::Vector3d dv_j(l.variance_j * l.in_j.x(), l.variance_j * l.in_j.y(), 0);
    const Eigen::Vector3d on_line_i = l.x_i - ratio * dv_i;
    const Eigen::Vector3d on_y = on_line_i.cross(t_);
    const Eigen::Vector3d on_t = l.y.cross(on_line_i) - ratio * (r_ * dv_j).cross(l.x_i);
    const Eigen::Vector3d on_w = l.x_j.cross(r_.transpose() * on_y) - ratio * dv_j.cross(l.in_j);
    *jacobian << on_w.transpose(), on_t.transpose() * basis_;
    *jacobian *= inverse_sigma;
  }
  return algebraic * inverse_sigma;
}

DepthSign EpipolarGeometry::depth_sign(const Correspondence& match) const {
  // depth_i x_i = depth_j y + t; crossed with y, and with x_i.
  const Eigen::Vector3d x = match.x_i.homogeneous(), y = r_ * match.x_j.homogeneous();
  const Eigen::Vector3d normal = x.cross(y);
  const double noise = 3 * std::hypot(match.sigma_i, match.sigma_j);
  if (normal.squaredNorm() < noise * noise * x.squaredNorm() * y.squaredNorm())
    return DepthSign::kUndecided;
  const bool in_front = t_.cross(y).dot(normal) > 0 && t_.cross(x).dot(normal) > 0;
  return in_front ? DepthSign::kInFront : DepthSign::kBehind;
}

Eigen::Matrix2d EpipolarGeometry::jacobian_noise(const Correspondence& match) const {
  const Lines l = lines_of(match);
  if (!(l.variance > 0)) return Eigen::Matrix2d::Zero();
  // To first order J is (y x x_i)' B / sqrt(variance); x_i and x_j move along their lines.
  const Eigen::Vector3d along_i = Eigen::Vector3d(-l.in_i.y(), l.in_i.x(), 0).normalized();
  const Eigen::Vector3d along_j = Eigen::Vector3d(-l.in_j.y(), l.in_j.x(), 0).normalized();
  const Eigen::Vector2d change_i = basis_.transpose() * l.y.cross(along_i);
  const Eigen::Vector2d change_j = basis_.transpose() * (r_ * along_j).cross(l.x_i);
  return (l.variance_i * change_i * change_i.transpose() +
          l.variance_j * change_j * change_j.transpose()) /
         l.variance;
}

double sampson_residual(const Correspondence& match, const RelativePose& pose,
                        Eigen::Matrix<double, 1, 5>* jacobian) {
  return EpipolarGeometry(pose).residual(match, jacobian);
}

}  // namespace eifmap
