#include "filter/landmark_distance.h"

#include <Eigen/LU>
#include <algorithm>

namespace eifmap {
namespace {

// V^-1 of the present derivatives; damped as where the filter eliminates the landmark.
Eigen::Matrix3d covariance_now(const FilterLandmark& landmark) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const PointMeasurement& m : landmark.measurements)
    information.noalias() += m.now.to_landmark.transpose() * m.now.to_landmark;
  const double trace = information.trace();
  if (!(trace > 0)) return Eigen::Matrix3d::Zero();
  information.diagonal().array() += 1e-14 * trace;
  return information.inverse();
}

// `along`: the distance's derivative to the landmark's place.
double add(AbsoluteRows& rows, const FilterLandmark& landmark, const Eigen::RowVector3d& along) {
  const Eigen::Matrix3d covariance = covariance_now(landmark);
  for (const PointMeasurement& m : landmark.measurements)
    rows.of(m.pose).derivative.topRows<1>() -=
        along * covariance * m.now.to_landmark.transpose() * m.d_pose_now();
  return along * covariance * along.transpose();
}

}  // namespace

DistanceRows linearize_distance(const FilterLandmark& a, const FilterLandmark& b, double metres) {
  constexpr double kCoincide = 1e-9;  // m
  DistanceRows distance;
  const Eigen::Vector3d step = b.position - a.position;
  const double size = step.norm();
  const Eigen::RowVector3d along =
      size > kCoincide ? Eigen::RowVector3d(step.transpose() / size) : Eigen::RowVector3d::Zero();
  distance.of_a = add(distance.rows, a, -along);
  distance.of_b = add(distance.rows, b, along);
  std::sort(distance.rows.of_pose.begin(), distance.rows.of_pose.end(),
            [](const PoseRows& one, const PoseRows& other) { return one.pose < other.pose; });
  distance.rows.residual.x() = metres - size;
  return distance;
}

}  // namespace eifmap
