#include "filter/reduced_system.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace eifmap {
namespace {

int block_of(int pose) {
  return pose - 1;
}

// Every pair of poses (b, a), b <= a, that meets in a landmark, as blocks.
template <class Action>
void for_each_pair(const FilterLandmark& landmark, Action action) {
  const auto& measurements = landmark.measurements;
  for (std::size_t k = 0; k < measurements.size(); ++k)
    for (std::size_t l = 0; l <= k; ++l) {
      const int b = block_of(std::min(measurements[k].pose, measurements[l].pose));
      if (b >= 0) action(b, block_of(std::max(measurements[k].pose, measurements[l].pose)));
    }
}

// What is left for the poses once the landmark is eliminated; its own step needs the same again.
void add_right_side(const FilterLandmark& landmark, Eigen::VectorXd& right_side) {
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const PointMeasurement& m : landmark.measurements)
    b.noalias() += m.d_landmark.transpose() * m.residual;
  const Eigen::Vector3d step = landmark.v_inverse * b;
  for (const PointMeasurement& m : landmark.measurements) {
    const int a = block_of(m.pose);
    if (a < 0) continue;
    const Eigen::Vector2d left = m.residual - m.d_landmark * step;
    right_side.segment<6>(6 * a).noalias() += m.d_pose.transpose() * left;
  }
}

}  // namespace

// A trace of damping keeps a feature whose rays are nearly parallel from making V singular, and is
// far below any information that a sighting brings.
Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark) {
  Eigen::Matrix3d v = Eigen::Matrix3d::Zero();
  for (const PointMeasurement& m : landmark.measurements)
    v.noalias() += m.d_landmark.transpose() * m.d_landmark;
  v.diagonal().array() += 1e-13 * v.trace();
  if (!(v.trace() > 0)) return Eigen::Matrix3d::Zero();
  return v.llt().solve(Eigen::Matrix3d::Identity());
}

void ReducedSystem::mark(const FilterLandmark& landmark) {
  for_each_pair(landmark, [this](int b, int a) {
    if (a >= of_landmarks_.size) return;  // came and went between two sums
    if (const int at = slot(b, a); at >= 0) stale_[static_cast<std::size_t>(at)] = 1;
  });
}

void ReducedSystem::before_removal(const FilterLandmark& landmark) {
  mark(landmark);
}

void ReducedSystem::index_slots() {
  const int n = of_landmarks_.size;
  slot_start_.resize(static_cast<std::size_t>(n));
  slots_.assign(static_cast<std::size_t>(n) * (static_cast<std::size_t>(n) + 1) / 2, -1);
  std::size_t start = 0;
  for (int a = 0; a < n; ++a) {
    slot_start_[static_cast<std::size_t>(a)] = start;
    for (int k = of_landmarks_.start[a]; k < of_landmarks_.start[a + 1]; ++k)
      slots_[start + static_cast<std::size_t>(of_landmarks_.row[k])] = k;
    start += static_cast<std::size_t>(a) + 1;
  }
}

// Which poses meet: those that share a feature or an edge. Blocks that were there and are not stale
// keep their sum.
void ReducedSystem::renew_pattern(int num_poses, const std::vector<FilterLandmark>& landmarks,
                                  const std::vector<FilterEdge>& edges) {
  const int n = num_poses - 1;
  std::vector<std::vector<bool>> meets(static_cast<std::size_t>(n));
  for (int a = 0; a < n; ++a) meets[a].resize(a + 1), meets[a][a] = true;
  for (const FilterLandmark& landmark : landmarks)
    for_each_pair(landmark, [&meets](int b, int a) { meets[a][b] = true; });
  for (const FilterEdge& edge : edges)
    if (const int b = block_of(std::min(edge.i, edge.j)); b >= 0)
      meets[block_of(std::max(edge.i, edge.j))][b] = true;

  BlockMatrix renewed;
  std::vector<std::uint8_t> stale;
  renewed.size = n;
  renewed.start.push_back(0);
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b <= a; ++b) {
      if (!meets[a][b]) continue;
      const int old = a < of_landmarks_.size ? slot(b, a) : -1;
      renewed.row.push_back(b);
      renewed.block.push_back(old < 0 ? PoseBlock::Zero() : of_landmarks_.block[old]);
      stale.push_back(old < 0 ? 1 : stale_[static_cast<std::size_t>(old)]);
    }
    renewed.start.push_back(static_cast<int>(renewed.row.size()));
  }
  of_landmarks_ = std::move(renewed);
  stale_ = std::move(stale);
  index_slots();
}

void ReducedSystem::sum_blocks(const FilterLandmark& landmark) {
  const auto& measurements = landmark.measurements;
  thread_local std::vector<Eigen::Matrix<double, 6, 3>> w;
  w.clear();
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const PointMeasurement& m = measurements[k];
    const int a = block_of(m.pose);
    if (a < 0) continue;
    Eigen::Matrix<double, 6, 3> w_v;
    bool has_w_v = false;
    for (std::size_t l = 0; l < measurements.size(); ++l) {
      const int b = block_of(measurements[l].pose);
      if (b < 0 || b > a) continue;
      const int at = slot(b, a);
      if (!stale_[static_cast<std::size_t>(at)]) continue;
      if (w.empty())
        for (const PointMeasurement& each : measurements)
          w.emplace_back(each.d_pose.transpose() * each.d_landmark);
      if (!has_w_v) w_v.noalias() = w[k] * landmark.v_inverse;
      has_w_v = true;
      PoseBlock& block = of_landmarks_.block[at];
      if (l == k) block.noalias() += m.d_pose.transpose() * m.d_pose;
      block.noalias() -= w[l] * w_v.transpose();
    }
  }
}

void ReducedSystem::add_edge(const FilterEdge& edge) {
  const int i = block_of(edge.i), j = block_of(edge.j);
  const RelativePoseLinearization& lin = edge.linearization;
  if (i >= 0) {
    matrix_.block[slot(i, i)].noalias() += lin.d_i.transpose() * lin.d_i;
    right_side_.segment<6>(6 * i).noalias() += lin.d_i.transpose() * lin.residual;
  }
  if (j >= 0) {
    matrix_.block[slot(j, j)].noalias() += lin.d_j.transpose() * lin.d_j;
    right_side_.segment<6>(6 * j).noalias() += lin.d_j.transpose() * lin.residual;
  }
  if (i < 0 || j < 0) return;
  if (i < j)
    matrix_.block[slot(i, j)].noalias() += lin.d_i.transpose() * lin.d_j;
  else
    matrix_.block[slot(j, i)].noalias() += lin.d_j.transpose() * lin.d_i;
}

void ReducedSystem::sum(int num_poses, std::vector<FilterLandmark>& landmarks,
                        const std::vector<FilterEdge>& edges, bool same_pattern) {
  if (!same_pattern) renew_pattern(num_poses, landmarks, edges);
  for (FilterLandmark& landmark : landmarks) {
    if (!landmark.changed) continue;
    mark(landmark);
    landmark.v_inverse = conditional_covariance(landmark);
    landmark.changed = false;
  }
  num_blocks_summed_ = 0;
  for (std::size_t k = 0; k < stale_.size(); ++k) {
    if (!stale_[k]) continue;
    of_landmarks_.block[k].setZero();
    ++num_blocks_summed_;
  }
  right_side_.setZero(of_landmarks_.size * kPoseDof);
  for (const FilterLandmark& landmark : landmarks) {
    sum_blocks(landmark);
    add_right_side(landmark, right_side_);
  }
  std::fill(stale_.begin(), stale_.end(), std::uint8_t{0});
  matrix_ = of_landmarks_;
  for (const FilterEdge& edge : edges) add_edge(edge);
}

void ReducedSystem::add_scale_gauge(const ScaleGauge& gauge, const Eigen::Vector3d& baseline) {
  const Eigen::Vector3d& u = gauge.direction;
  PoseBlock& block = matrix_.block[slot(0, 0)];
  const double weight = 1e6 * block.bottomRightCorner<3, 3>().trace();
  block.bottomRightCorner<3, 3>().noalias() += weight * u * u.transpose();
  right_side_.segment<3>(3) += weight * (gauge.length - u.dot(baseline)) * u;
}

}  // namespace eifmap
