#include "filter/absolute_observation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace eifmap {
namespace {

// Adds what the point's displacement in the map, through `to_point`, is by its pose's error.
template <int N>
void add(AbsoluteRows& rows, const RigidPoint& point, const Rigid3& map_from_pose,
         const Eigen::Matrix<double, N, 3>& to_point) {
  auto derivative = rows.of(point.pose).derivative.template topRows<N>();
  derivative.template leftCols<3>() -= to_point * map_from_pose.matrix() * skew(point.in_pose);
  derivative.template rightCols<3>() += to_point;
}

void linearize_length(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                      AbsoluteRows& rows) {
  constexpr double kCoincide = 1e-9;  // m
  const std::vector<RigidPoint>& points = observation.points;
  double length = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const RigidPoint &a = points[k - 1], &b = points[k];
    const Eigen::Vector3d step = poses[b.pose] * b.in_pose - poses[a.pose] * a.in_pose;
    const double size = step.norm();
    length += size;
    const Eigen::RowVector3d along =
        size > kCoincide ? Eigen::RowVector3d(step.transpose() / size) : Eigen::RowVector3d::Zero();
    add<1>(rows, a, poses[a.pose], -along);
    add<1>(rows, b, poses[b.pose], along);
  }
  rows.residual.x() = observation.value.x() - length;
}

void linearize_position(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                        const Rigid3& earth_from_map, AbsoluteRows& rows) {
  const RigidPoint& point = observation.points.front();
  const Eigen::Vector3d in_map = poses[point.pose] * point.in_pose;
  const Eigen::Matrix3d rotation = earth_from_map.matrix();
  rows.residual = observation.value - earth_from_map * in_map;
  add<3>(rows, point, poses[point.pose], rotation);
  PoseRows& of_earth = rows.of(kEarthFromMap);
  of_earth.derivative.leftCols<3>() = -rotation * skew(in_map);
  of_earth.derivative.rightCols<3>().setIdentity();
}

constexpr double kSmall = 1e-4;  // of a sine

// An angle over its sine, and the derivative of that to the sine.
struct OverSine {
  double value = 1, derivative = 0;
};
OverSine angle_over_sine(double sine, double cosine) {
  constexpr double kSquare = 0.1;  // of the cosine: nearer to a right angle constant
  if (sine < kSmall && cosine > 0) return {1, sine / 3};
  OverSine over;
  over.value = std::atan2(sine, cosine) / std::max(sine, kSmall);
  if (std::abs(cosine) > kSquare) over.derivative = (1 / cosine - over.value) / sine;
  return over;
}

// The turn, along the measured direction's tangents, from where down should be to where it was
// measured: the angle and not its sine, which would take upside down for right.
void linearize_down(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                    const Rigid3& earth_from_map, AbsoluteRows& rows) {
  const int pose = observation.points.front().pose;
  const Eigen::Matrix3d camera_from_map = poses[pose].matrix().transpose();
  const Eigen::Vector3d down_in_map = -earth_from_map.matrix().row(2).transpose();
  const Eigen::Vector3d expected = camera_from_map * down_in_map;
  const Eigen::Matrix<double, 2, 3> tangents = tangents_of(observation.value);
  const Eigen::Vector2d off = tangents * expected;
  const double sine = off.norm();
  const OverSine over = angle_over_sine(sine, observation.value.dot(expected));
  rows.residual.head<2>() = -over.value * off;
  if (sine < kSmall && observation.value.dot(expected) < 0)  // upside down, by whichever way
    rows.residual.head<2>() = Eigen::Vector2d(EIGEN_PI, 0);
  Eigen::Matrix2d to_off = over.value * Eigen::Matrix2d::Identity();
  if (sine > 0) to_off += over.derivative / sine * off * off.transpose();
  const Eigen::Matrix<double, 2, 3> to_expected = to_off * tangents;
  rows.of(pose).derivative.topLeftCorner<2, 3>() = to_expected * skew(expected);
  rows.of(kEarthFromMap).derivative.topLeftCorner<2, 3>() =
      to_expected * camera_from_map * skew(down_in_map);
}

}  // namespace

int AbsoluteObservation::rows() const {
  if (kind == Kind::kPosition) return 3;
  return kind == Kind::kDown ? 2 : 1;
}

AbsoluteObservation AbsoluteObservation::length(std::vector<RigidPoint> points, double metres,
                                                double sigma) {
  AbsoluteObservation o;
  o.kind = Kind::kLength;
  o.points = std::move(points);
  o.value = {metres, 0, 0};
  o.covariance(0, 0) = sigma * sigma;
  return o;
}

AbsoluteObservation AbsoluteObservation::position(const RigidPoint& point,
                                                  const Eigen::Vector3d& in_earth,
                                                  const Eigen::Matrix3d& covariance) {
  AbsoluteObservation o;
  o.kind = Kind::kPosition;
  o.points = {point};
  o.value = in_earth;
  o.covariance = covariance;
  return o;
}

AbsoluteObservation AbsoluteObservation::down(int pose, const Eigen::Vector3d& direction,
                                              const Eigen::Matrix3d& covariance) {
  AbsoluteObservation o;
  o.kind = Kind::kDown;
  o.points = {RigidPoint(pose)};
  o.value = direction.normalized();
  const Eigen::Matrix<double, 2, 3> by_turn = tangents_of(o.value) * skew(o.value);
  o.covariance.topLeftCorner<2, 2>() = by_turn * covariance * by_turn.transpose();
  return o;
}

AbsoluteObservation AbsoluteObservation::distance(int landmark, int other, double metres,
                                                  double sigma) {
  AbsoluteObservation o;
  o.kind = Kind::kLandmarks;
  o.landmarks = {landmark, other};
  o.value = {metres, 0, 0};
  o.covariance(0, 0) = sigma * sigma;
  return o;
}

Eigen::Matrix<double, 2, 3> tangents_of(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 2, 3> tangents;
  tangents.row(0) = direction.unitOrthogonal().transpose();
  tangents.row(1) = direction.cross(tangents.row(0).transpose()).normalized().transpose();
  return tangents;
}

PoseRows& AbsoluteRows::of(int pose) {
  const auto at = std::find_if(of_pose.begin(), of_pose.end(),
                               [pose](const PoseRows& r) { return r.pose == pose; });
  if (at != of_pose.end()) return *at;
  of_pose.emplace_back();
  of_pose.back().pose = pose;
  return of_pose.back();
}

double AbsoluteRows::squared_derivative() const {
  double sum = 0;
  for (const PoseRows& rows : of_pose) sum += rows.derivative.squaredNorm();
  return sum;
}

AbsoluteRows linearize(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                       const Rigid3& earth_from_map) {
  AbsoluteRows rows;
  switch (observation.kind) {
    case AbsoluteObservation::Kind::kLength:
      linearize_length(observation, poses, rows);
      return rows;
    case AbsoluteObservation::Kind::kPosition:
      linearize_position(observation, poses, earth_from_map, rows);
      return rows;
    case AbsoluteObservation::Kind::kDown:
      linearize_down(observation, poses, earth_from_map, rows);
      return rows;
    case AbsoluteObservation::Kind::kLandmarks:
      break;
  }
  throw std::invalid_argument("linearize: a distance of landmarks is linearized with them");
}

bool whitening(const AbsoluteObservation& observation, Eigen::Matrix3d& whiten) {
  whiten.setZero();
  if (observation.is_length()) {
    whiten(0, 0) = 1 / std::sqrt(observation.covariance(0, 0));
    return observation.covariance(0, 0) > 0 && std::isfinite(whiten(0, 0)) && whiten(0, 0) > 0;
  }
  if (!observation.covariance.allFinite()) return false;
  const int n = observation.rows();
  const Eigen::MatrixXd covariance = observation.covariance.topLeftCorner(n, n);
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return false;
  whiten.topLeftCorner(n, n) = factor.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
  return whiten.allFinite();
}

}  // namespace eifmap
