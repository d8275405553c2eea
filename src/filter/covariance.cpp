// Covariances out of the factor of S: never the inverse as a whole.
#include <algorithm>

#include "filter/information_filter.h"

namespace eifmap {
namespace {

// The derivative of a landmark's position to the error of one pose that sees it, -V^-1 W'. Poses
// repeat nowhere: a landmark has at most one measurement per pose.
using PointSensitivity = Eigen::Matrix<double, 3, kPoseDof>;
PointSensitivity sensitivity(const FilterLandmark& landmark, const PointMeasurement& m) {
  return -landmark.covariance * (m.frozen.to_landmark.transpose() * m.d_pose());
}

// Sigma_pp of some poses: their blocks of S^-1, zero rows and columns for the gauge pose.
class JointCovariance {
 public:
  JointCovariance(std::vector<int> poses, const PoseBlocks& blocks, int num_blocks,
                  const SparseCholesky& cholesky)
      : poses_(std::move(poses)) {
    const auto columns = static_cast<Eigen::Index>(poses_.size() * kPoseDof);
    Eigen::MatrixXd selected = Eigen::MatrixXd::Zero(num_blocks * kPoseDof, columns);
    for (std::size_t k = 0; k < poses_.size(); ++k)
      if (poses_[k] != 0)
        selected
            .block<kPoseDof, kPoseDof>(blocks.of(poses_[k]) * kPoseDof,
                                       static_cast<Eigen::Index>(k) * kPoseDof)
            .setIdentity();
    const Eigen::MatrixXd whitened = cholesky.whiten(selected);
    joint_.setZero(columns, columns);
    joint_.selfadjointView<Eigen::Lower>().rankUpdate(whitened.transpose());
    joint_.triangularView<Eigen::StrictlyUpper>() = joint_.transpose();
  }

  auto block(int a, int b) const {
    return joint_.block<kPoseDof, kPoseDof>(place(a) * kPoseDof, place(b) * kPoseDof);
  }

 private:
  Eigen::Index place(int pose) const {
    return std::lower_bound(poses_.begin(), poses_.end(), pose) - poses_.begin();
  }

  std::vector<int> poses_;  // ascending
  Eigen::MatrixXd joint_;
};

Eigen::Matrix3d marginal(const FilterLandmark& landmark, const JointCovariance& joint) {
  const auto& measurements = landmark.measurements;
  std::vector<PointSensitivity> to_pose;
  for (const PointMeasurement& m : measurements) to_pose.push_back(sensitivity(landmark, m));
  Eigen::Matrix3d covariance = landmark.covariance;
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    PointSensitivity row = PointSensitivity::Zero();
    for (std::size_t l = 0; l < measurements.size(); ++l)
      row.noalias() += to_pose[l] * joint.block(measurements[l].pose, measurements[k].pose);
    covariance.noalias() += row * to_pose[k].transpose();
  }
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

bool InformationFilter::covariances(const std::vector<int>& poses,
                                    const std::vector<int>& landmarks,
                                    std::vector<PoseBlock>& of_poses,
                                    std::vector<Eigen::Matrix3d>& of_landmarks) const {
  of_poses.clear();
  of_landmarks.clear();
  if (poses.empty() && landmarks.empty()) return true;
  std::vector<int> needed = poses;
  for (int l : landmarks)
    for (const PointMeasurement& m : landmarks_.at(l).measurements) needed.push_back(m.pose);
  std::sort(needed.begin(), needed.end());
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
  if (!std::all_of(needed.begin(), needed.end(), [this](int p) { return knows(p); })) return false;
  const JointCovariance joint(needed, blocks(), system_.matrix().size(), cholesky_);
  const double factor = variance();
  for (int p : poses) of_poses.push_back(factor * joint.block(p, p));
  for (int l : landmarks) of_landmarks.push_back(factor * marginal(landmarks_[l], joint));
  return true;
}

bool InformationFilter::pose_covariance(int pose, PoseBlock& covariance) const {
  std::vector<PoseBlock> of_poses;
  std::vector<Eigen::Matrix3d> of_landmarks;
  if (!covariances({pose}, {}, of_poses, of_landmarks)) return false;
  covariance = of_poses.front();
  return covariance.allFinite();
}

bool InformationFilter::landmark_covariance(int landmark, Eigen::Matrix3d& covariance) const {
  std::vector<PoseBlock> of_poses;
  std::vector<Eigen::Matrix3d> of_landmarks;
  if (!covariances({}, {landmark}, of_poses, of_landmarks)) return false;
  covariance = of_landmarks.front();
  return covariance.allFinite();
}

bool InformationFilter::propagate(const std::vector<PoseSensitivity>& sensitivities,
                                  PoseBlock& covariance) const {
  if (!cholesky_.has_factor()) return false;
  Eigen::MatrixXd functions = Eigen::MatrixXd::Zero(system_.matrix().size() * kPoseDof, kPoseDof);
  for (const PoseSensitivity& s : sensitivities) {
    if (!knows(s.pose)) return false;
    if (s.pose != 0)
      functions.middleRows<kPoseDof>(blocks().of(s.pose) * kPoseDof) += s.derivative.transpose();
  }
  const Eigen::MatrixXd whitened = cholesky_.whiten(functions);
  covariance = variance() * (whitened.transpose() * whitened);
  return covariance.allFinite();
}

bool InformationFilter::steps_of(const Eigen::MatrixXd& right_sides, Eigen::MatrixXd& steps) const {
  if (!cholesky_.has_factor() || right_sides.rows() != system_.matrix().size() * kPoseDof)
    return false;
  steps = cholesky_.solve(right_sides);
  return steps.allFinite();
}

}  // namespace eifmap
