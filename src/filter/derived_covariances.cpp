#include "filter/derived_covariances.h"

#include <utility>

namespace eifmap {

bool relative_covariance(const InformationFilter& filter, int a, int b, PoseBlock& covariance) {
  if (a == b) {
    covariance.setZero();
    return true;
  }
  const Rigid3 a_from_b = filter.pose(a).inverse() * filter.pose(b);
  const Eigen::Matrix3d a_from_map = filter.pose(a).matrix().transpose();
  PoseSensitivity of_a{a, PoseBlock::Zero()}, of_b{b, PoseBlock::Zero()};
  of_a.derivative.topLeftCorner<3, 3>() = -a_from_b.matrix().transpose();
  of_a.derivative.bottomLeftCorner<3, 3>() = skew(a_from_b.translation);
  of_a.derivative.bottomRightCorner<3, 3>() = -a_from_map;
  of_b.derivative.topLeftCorner<3, 3>().setIdentity();
  of_b.derivative.bottomRightCorner<3, 3>() = a_from_map;
  return filter.propagate({of_a, of_b}, covariance);
}

bool earth_is_certain(const InformationFilter& filter) {
  PoseBlock covariance;
  return filter.has_level() &&
         filter.propagate({{kEarthFromMap, PoseBlock::Identity()}}, covariance) &&
         covariance.topLeftCorner<3, 3>().trace() < kEarthUncertain * kEarthUncertain;
}

bool covariance_in_earth(const InformationFilter& filter, int pose, PoseBlock& covariance) {
  if (!filter.has_level()) return false;
  const Rigid3& map_from_camera = filter.pose(pose);
  const Eigen::Matrix3d turn = filter.earth_from_map().matrix();
  PoseSensitivity of_pose{pose, PoseBlock::Identity()};
  of_pose.derivative.bottomRightCorner<3, 3>() = turn;
  PoseSensitivity of_earth{kEarthFromMap, PoseBlock::Identity()};
  of_earth.derivative.topLeftCorner<3, 3>() = map_from_camera.matrix().transpose();
  of_earth.derivative.bottomLeftCorner<3, 3>() = -turn * skew(map_from_camera.translation);
  return filter.propagate({of_pose, of_earth}, covariance);
}

bool landmark_covariance_in_earth(const InformationFilter& filter, int landmark,
                                  Eigen::Matrix3d& covariance) {
  if (!filter.has_level()) return false;
  const FilterLandmark& l = filter.landmark(landmark);
  const Eigen::Matrix3d turn = filter.earth_from_map().matrix();
  // Its position moves with the poses that see it by -V^-1 W', and by V^-1 of its own.
  std::vector<PoseSensitivity> sensitivities;
  for (const PointMeasurement& m : l.measurements) {
    sensitivities.push_back({m.pose, PoseBlock::Zero()});
    sensitivities.back().derivative.topRows<3>() =
        -turn * l.covariance * (m.frozen.to_landmark.transpose() * m.d_pose());
  }
  sensitivities.push_back({kEarthFromMap, PoseBlock::Zero()});
  sensitivities.back().derivative.topLeftCorner<3, 3>() = -turn * skew(l.position);
  sensitivities.back().derivative.topRightCorner<3, 3>().setIdentity();
  PoseBlock of_poses;
  if (!filter.propagate(sensitivities, of_poses)) return false;
  covariance = filter.variance() * turn * l.covariance * turn.transpose();
  covariance += of_poses.topLeftCorner<3, 3>();
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  return covariance.allFinite();
}

bool log_scale_derivative(const InformationFilter& filter, const std::vector<int>& poses,
                          Eigen::Matrix3Xd& to_centres) {
  if (poses.size() < 2) return false;
  to_centres.resize(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t k = 0; k < poses.size(); ++k)
    to_centres.col(static_cast<Eigen::Index>(k)) = filter.pose(poses[k]).translation;
  const Eigen::Vector3d mean = to_centres.rowwise().mean();
  to_centres.colwise() -= mean;
  const double squared = to_centres.squaredNorm();
  to_centres /= squared;
  return squared > 0;
}

bool log_scale_variance(const InformationFilter& filter, const std::vector<int>& poses,
                        double& variance) {
  Eigen::Matrix3Xd to_centres;
  if (!log_scale_derivative(filter, poses, to_centres)) return false;
  std::vector<PoseSensitivity> sensitivities;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    sensitivities.push_back({poses[k], PoseBlock::Zero()});
    sensitivities.back().derivative.row(0).tail<3>() =
        to_centres.col(static_cast<Eigen::Index>(k)).transpose();
  }
  PoseBlock covariance;
  if (!filter.propagate(sensitivities, covariance)) return false;
  variance = covariance(0, 0);
  return true;
}

}  // namespace eifmap
