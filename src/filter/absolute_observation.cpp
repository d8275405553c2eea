#include "filter/absolute_observation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace eifmap {
namespace {

PoseRows& rows_of(AbsoluteRows& rows, int pose) {
  const auto at = std::find_if(rows.of_pose.begin(), rows.of_pose.end(),
                               [pose](const PoseRows& r) { return r.pose == pose; });
  if (at != rows.of_pose.end()) return *at;
  rows.of_pose.emplace_back();
  rows.of_pose.back().pose = pose;
  return rows.of_pose.back();
}

// Adds what the point's displacement in the map, through `to_point`, is by its pose's error.
template <int N>
void add(AbsoluteRows& rows, const RigidPoint& point, const Rigid3& map_from_pose,
         const Eigen::Matrix<double, N, 3>& to_point) {
  auto derivative = rows_of(rows, point.pose).derivative.template topRows<N>();
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
  PoseRows& of_earth = rows_of(rows, kEarthFromMap);
  of_earth.derivative.leftCols<3>() = -rotation * skew(in_map);
  of_earth.derivative.rightCols<3>().setIdentity();
}

}  // namespace

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
  return {Kind::kPosition, {point}, in_earth, covariance};
}

double AbsoluteRows::squared_derivative() const {
  double sum = 0;
  for (const PoseRows& rows : of_pose) sum += rows.derivative.squaredNorm();
  return sum;
}

AbsoluteRows linearize(const AbsoluteObservation& observation, const std::vector<Rigid3>& poses,
                       const Rigid3& earth_from_map) {
  AbsoluteRows rows;
  if (observation.kind == AbsoluteObservation::Kind::kLength)
    linearize_length(observation, poses, rows);
  else
    linearize_position(observation, poses, earth_from_map, rows);
  return rows;
}

bool whitening(const AbsoluteObservation& observation, Eigen::Matrix3d& whiten) {
  whiten.setZero();
  if (observation.kind == AbsoluteObservation::Kind::kLength) {
    whiten(0, 0) = 1 / std::sqrt(observation.covariance(0, 0));
    return observation.covariance(0, 0) > 0 && std::isfinite(whiten(0, 0)) && whiten(0, 0) > 0;
  }
  if (!observation.covariance.allFinite()) return false;
  const Eigen::LLT<Eigen::Matrix3d> factor(observation.covariance);
  if (factor.info() != Eigen::Success) return false;
  whiten = factor.matrixL().solve(Eigen::Matrix3d::Identity());
  return whiten.allFinite();
}

}  // namespace eifmap
