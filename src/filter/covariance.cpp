// Covariances out of the factor of S: never the inverse as a whole.
#include <algorithm>
#include <utility>

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

// The same of many poses: the blocks that the factor has, which are those of poses that see a
// landmark together, and no others.
class SparseJointCovariance {
 public:
  SparseJointCovariance(const PoseBlocks& blocks, const SparseCholesky& cholesky)
      : blocks_(blocks), inverse_(cholesky.selected_inverse()) {}

  PoseBlock block(int a, int b) const {
    PoseBlock found = PoseBlock::Zero();
    if (a != 0 && b != 0)
      has_all_ = inverse_.block(blocks_.of(a), blocks_.of(b), found) && has_all_;
    return found;
  }
  // Since the last call.
  bool had_all() const { return std::exchange(has_all_, true); }

 private:
  const PoseBlocks& blocks_;
  SelectedInverse inverse_;
  mutable bool has_all_ = true;
};

template <class Joint>
Eigen::Matrix3d marginal(const FilterLandmark& landmark, const Joint& joint) {
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

// More poses than this: their blocks alone cost less than all that they have to do with each other,
// of a map of 784 keyframes a hundredth.
constexpr std::size_t kMany = 150;

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
  const double factor = variance();
  if (needed.size() > kMany) return sparse_covariances(poses, landmarks, of_poses, of_landmarks);
  const JointCovariance joint(needed, blocks(), system_.matrix().size(), cholesky_);
  for (int p : poses) of_poses.push_back(factor * joint.block(p, p));
  for (int l : landmarks) of_landmarks.push_back(factor * marginal(landmarks_[l], joint));
  return true;
}

// What has come since the last factorization may be of poses that the factor does not join.
bool InformationFilter::sparse_covariances(const std::vector<int>& poses,
                                           const std::vector<int>& landmarks,
                                           std::vector<PoseBlock>& of_poses,
                                           std::vector<Eigen::Matrix3d>& of_landmarks) const {
  const SparseJointCovariance joint(blocks(), cholesky_);
  for (int p : poses) of_poses.push_back(variance() * joint.block(p, p));
  for (int l : landmarks) {
    of_landmarks.push_back(variance() * marginal(landmarks_[l], joint));
    if (joint.had_all()) continue;
    std::vector<int> of;
    for (const PointMeasurement& m : landmarks_[l].measurements) of.push_back(m.pose);
    std::sort(of.begin(), of.end());
    const JointCovariance dense(of, blocks(), system_.matrix().size(), cholesky_);
    of_landmarks.back() = variance() * marginal(landmarks_[l], dense);
  }
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
