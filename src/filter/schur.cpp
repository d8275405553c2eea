#include "filter/schur.h"

#include <Eigen/Cholesky>

namespace eifmap {
namespace {

int block_of(int pose) {
  return pose - 1;
}

// V and b of a feature; a trace of damping keeps a feature whose rays are nearly parallel from
// making V singular, and is far below any information that a sighting brings. False when no
// sighting says anything, as behind all cameras: then V is zero, and the feature is to be left
// alone.
bool sum_landmark(const FilterLandmark& landmark, Eigen::Matrix3d& v, Eigen::Vector3d& b) {
  v.setZero();
  b.setZero();
  for (const PointMeasurement& m : landmark.measurements) {
    v.noalias() += m.d_landmark.transpose() * m.d_landmark;
    b.noalias() += m.d_landmark.transpose() * m.residual;
  }
  v.diagonal().array() += 1e-13 * v.trace();
  return v.trace() > 0;
}

}  // namespace

BlockMatrix reduced_pattern(int num_poses, const std::vector<FilterLandmark>& landmarks,
                            const std::vector<FilterEdge>& edges) {
  const int n = num_poses - 1;
  std::vector<std::vector<bool>> meets(n);
  for (int a = 0; a < n; ++a) meets[a].resize(a + 1), meets[a][a] = true;
  const auto mark = [&meets](int pose_a, int pose_b) {
    const int a = std::max(block_of(pose_a), block_of(pose_b));
    const int b = std::min(block_of(pose_a), block_of(pose_b));
    if (b >= 0) meets[a][b] = true;
  };
  for (const FilterLandmark& landmark : landmarks)
    for (std::size_t k = 0; k < landmark.measurements.size(); ++k)
      for (std::size_t l = 0; l < k; ++l)
        mark(landmark.measurements[k].pose, landmark.measurements[l].pose);
  for (const FilterEdge& edge : edges) mark(edge.i, edge.j);

  BlockMatrix matrix;
  matrix.size = n;
  matrix.start.push_back(0);
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b <= a; ++b)
      if (meets[a][b]) matrix.row.push_back(b);
    matrix.start.push_back(static_cast<int>(matrix.row.size()));
  }
  matrix.block.resize(matrix.row.size());
  return matrix;
}

namespace {

void reduce_landmark(const FilterLandmark& landmark, BlockMatrix& matrix,
                     Eigen::VectorXd& right_side) {
  const auto& measurements = landmark.measurements;
  if (measurements.empty()) return;
  Eigen::Matrix3d v;
  Eigen::Vector3d b;
  if (!sum_landmark(landmark, v, b)) return;
  const Eigen::Matrix3d v_inverse = v.llt().solve(Eigen::Matrix3d::Identity());
  const Eigen::Vector3d v_inverse_b = v_inverse * b;

  thread_local std::vector<Eigen::Matrix<double, 6, 3>> w;
  w.resize(measurements.size());
  for (std::size_t k = 0; k < measurements.size(); ++k)
    w[k].noalias() = measurements[k].d_pose.transpose() * measurements[k].d_landmark;

  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const PointMeasurement& m = measurements[k];
    const int a = block_of(m.pose);
    if (a < 0) continue;
    matrix.at(a, a).noalias() += m.d_pose.transpose() * m.d_pose;
    right_side.segment<6>(6 * a).noalias() +=
        m.d_pose.transpose() * m.residual - w[k] * v_inverse_b;
    const Eigen::Matrix<double, 6, 3> w_v = w[k] * v_inverse;
    for (std::size_t l = 0; l < measurements.size(); ++l) {
      const int c = block_of(measurements[l].pose);
      if (c < 0 || c > a) continue;
      matrix.at(c, a).noalias() -= w[l] * w_v.transpose();
    }
  }
}

void add_edge(const FilterEdge& edge, BlockMatrix& matrix, Eigen::VectorXd& right_side) {
  const int i = block_of(edge.i), j = block_of(edge.j);
  const RelativePoseLinearization& lin = edge.linearization;
  if (i >= 0) {
    matrix.at(i, i).noalias() += lin.d_i.transpose() * lin.d_i;
    right_side.segment<6>(6 * i).noalias() += lin.d_i.transpose() * lin.residual;
  }
  if (j >= 0) {
    matrix.at(j, j).noalias() += lin.d_j.transpose() * lin.d_j;
    right_side.segment<6>(6 * j).noalias() += lin.d_j.transpose() * lin.residual;
  }
  if (i < 0 || j < 0) return;
  if (i < j)
    matrix.at(i, j).noalias() += lin.d_i.transpose() * lin.d_j;
  else
    matrix.at(j, i).noalias() += lin.d_j.transpose() * lin.d_i;
}

}  // namespace

void reduce(const std::vector<FilterLandmark>& landmarks, const std::vector<FilterEdge>& edges,
            BlockMatrix& matrix, Eigen::VectorXd& right_side) {
  matrix.set_zero();
  right_side.setZero(matrix.size * kPoseDof);
  for (const FilterLandmark& landmark : landmarks) reduce_landmark(landmark, matrix, right_side);
  for (const FilterEdge& edge : edges) add_edge(edge, matrix, right_side);
}

void add_scale_gauge(const ScaleGauge& gauge, const Eigen::Vector3d& baseline, BlockMatrix& matrix,
                     Eigen::VectorXd& right_side) {
  const Eigen::Vector3d& u = gauge.direction;
  PoseBlock& block = matrix.at(0, 0);
  const double weight = 1e6 * block.bottomRightCorner<3, 3>().trace();
  block.bottomRightCorner<3, 3>().noalias() += weight * u * u.transpose();
  right_side.segment<3>(3) += weight * (gauge.length - u.dot(baseline)) * u;
}

Eigen::Vector3d landmark_step(const FilterLandmark& landmark, const Eigen::VectorXd& delta_poses) {
  Eigen::Matrix3d v;
  Eigen::Vector3d b;
  if (!sum_landmark(landmark, v, b)) return Eigen::Vector3d::Zero();
  for (const PointMeasurement& m : landmark.measurements) {
    const int a = block_of(m.pose);
    if (a < 0) continue;
    b.noalias() -= m.d_landmark.transpose() * (m.d_pose * delta_poses.segment<6>(6 * a)).eval();
  }
  return v.llt().solve(b);
}

Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark) {
  Eigen::Matrix3d v;
  Eigen::Vector3d b;
  if (!sum_landmark(landmark, v, b)) return landmark.covariance;
  return v.llt().solve(Eigen::Matrix3d::Identity());
}

}  // namespace eifmap
