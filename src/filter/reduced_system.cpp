#include "filter/reduced_system.h"

#include <algorithm>
#include <cmath>

namespace eifmap {
namespace {

const PointMeasurement& sight_from(const FilterLandmark& landmark, int pose) {
  return *std::find_if(landmark.measurements.begin(), landmark.measurements.end(),
                       [pose](const PointMeasurement& m) { return m.pose == pose; });
}

// A landmark's step while its poses stand still: V^-1 b = R^-1 Q' r.
Eigen::Vector3d step_alone(const FilterLandmark& landmark) {
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  for (const PointMeasurement& m : landmark.measurements)
    along.noalias() += m.q.transpose() * m.residual;
  return landmark.r_inverse * along;
}

}  // namespace

// By Gram-Schmidt, twice. A trace of damping keeps V from being singular, and is far below any
// information that a sighting brings.
void factor_landmark(FilterLandmark& landmark) {
  const auto m = static_cast<Eigen::Index>(landmark.measurements.size());
  thread_local Eigen::Matrix<double, Eigen::Dynamic, 3> q;
  q.resize(2 * m + 3, 3);
  for (Eigen::Index k = 0; k < m; ++k)
    q.middleRows<2>(2 * k) = landmark.measurements[static_cast<std::size_t>(k)].d_landmark;
  q.bottomRows<3>() =
      1e-7 * std::sqrt(q.topRows(2 * m).squaredNorm()) * Eigen::Matrix3d::Identity();
  Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
  landmark.r_inverse.setZero();
  for (int j = 0; j < 3; ++j) {
    for (int pass = 0; pass < 2; ++pass)
      for (int i = 0; i < j; ++i) {
        const double along = q.col(i).dot(q.col(j));
        q.col(j) -= along * q.col(i);
        r(i, j) += along;
      }
    r(j, j) = q.col(j).norm();
    if (r(j, j) > 0)
      q.col(j) /= r(j, j);
    else
      q.setZero();
  }
  if ((r.diagonal().array() > 0).all())
    landmark.r_inverse = r.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
  for (Eigen::Index k = 0; k < m; ++k)
    landmark.measurements[static_cast<std::size_t>(k)].q = q.middleRows<2>(2 * k);
}

Eigen::Matrix3d conditional_covariance(const FilterLandmark& landmark) {
  if (!landmark.changed) return landmark.r_inverse * landmark.r_inverse.transpose();
  FilterLandmark now = landmark;
  factor_landmark(now);
  return now.r_inverse * now.r_inverse.transpose();
}

void ReducedSystem::grow(int num_blocks) {
  for (int a = matrix_.size(); a < num_blocks; ++a) {
    matrix_.column.emplace_back();
    matrix_.column.back().insert(a);
    stale_.push_back({1});
    stale_column_.push_back(1);
    stale_side_.push_back(1);
  }
}

// The block of two poses is to be summed again. What came and went between two sums is in no
// column, and need not be.
void ReducedSystem::mark(int pose, int other, bool may_insert) {
  const int a = std::max(pose, other) - 1, b = std::min(pose, other) - 1;
  if (b < 0 || a >= matrix_.size()) return;
  BlockColumn& column = matrix_.column[a];
  int at = column.find(b);
  if (at < 0) {
    if (!may_insert) return;
    at = column.insert(b);
    stale_[a].insert(stale_[a].begin() + at, 1);
  }
  stale_[a][at] = 1;
  stale_column_[a] = 1;
}

void ReducedSystem::touch_right_side(int pose) {
  if (pose > 0 && pose <= matrix_.size()) stale_side_[pose - 1] = 1;
}

void ReducedSystem::mark_pairs(const FilterLandmark& landmark, bool may_insert) {
  const auto& measurements = landmark.measurements;
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    touch_right_side(measurements[k].pose);
    for (std::size_t l = 0; l <= k; ++l)
      mark(measurements[k].pose, measurements[l].pose, may_insert);
  }
}

void ReducedSystem::mark_blocks(const FilterEdge& edge, bool may_insert) {
  mark(edge.i, edge.i, may_insert);
  mark(edge.j, edge.j, may_insert);
  mark(edge.i, edge.j, may_insert);
  touch_right_side(edge.i);
  touch_right_side(edge.j);
}

void ReducedSystem::before_removal(const FilterLandmark& landmark) {
  mark_pairs(landmark, false);
}

void ReducedSystem::before_removal(const FilterEdge& edge) {
  mark_blocks(edge, false);
}

void ReducedSystem::sum_column(int a, const std::vector<int>& seen,
                               const std::vector<FilterLandmark>& landmarks) {
  BlockColumn& column = matrix_.column[a];
  slot_.assign(static_cast<std::size_t>(a) + 1, -1);
  for (std::size_t k = 0; k < column.row.size(); ++k) {
    if (!stale_[a][k]) continue;
    slot_[column.row[k]] = static_cast<int>(k);
    column.block[k].setZero();
    column.changed[k] = 1;
    ++num_blocks_summed_;
  }
  for (int l : seen) {
    const FilterLandmark& landmark = landmarks[l];
    const PointMeasurement& own = sight_from(landmark, a + 1);
    const Eigen::Matrix<double, 3, 6> q_d = own.q.transpose() * own.d_pose;
    for (const PointMeasurement& m : landmark.measurements) {
      const int b = m.pose - 1;
      if (b < 0 || b > a || slot_[b] < 0) continue;
      Eigen::Matrix<double, 2, 6> part = -(m.q * q_d);
      if (b == a) part += own.d_pose;
      column.block[slot_[b]].noalias() += m.d_pose.transpose() * part;
    }
  }
}

// What is left for the pose once the landmarks are eliminated.
void ReducedSystem::sum_right_side(int a, const std::vector<int>& seen,
                                   const std::vector<FilterLandmark>& landmarks) {
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  for (int l : seen) {
    const PointMeasurement& m = sight_from(landmarks[l], a + 1);
    const Eigen::Vector2d left = m.residual - m.d_landmark * landmarks[l].step;
    sum.noalias() += m.d_pose.transpose() * left;
  }
  right_side_.segment<6>(6 * a) = sum;
}

void ReducedSystem::add_to_block(int i, int j, const PoseBlock& part) {
  const int a = std::max(i, j) - 1, b = std::min(i, j) - 1;
  if (b < 0 || !stale_column_[a]) return;
  const int at = matrix_.column[a].find(b);
  if (stale_[a][at]) matrix_.column[a].block[at] += part;
}

void ReducedSystem::add_edge(const FilterEdge& edge) {
  const RelativePoseLinearization& lin = edge.linearization;
  add_to_block(edge.i, edge.i, lin.d_i.transpose() * lin.d_i);
  add_to_block(edge.j, edge.j, lin.d_j.transpose() * lin.d_j);
  if (edge.i < edge.j)
    add_to_block(edge.i, edge.j, lin.d_i.transpose() * lin.d_j);
  else
    add_to_block(edge.i, edge.j, lin.d_j.transpose() * lin.d_i);
  if (edge.i > 0 && stale_side_[edge.i - 1])
    right_side_.segment<6>(6 * (edge.i - 1)).noalias() += lin.d_i.transpose() * lin.residual;
  if (edge.j > 0 && stale_side_[edge.j - 1])
    right_side_.segment<6>(6 * (edge.j - 1)).noalias() += lin.d_j.transpose() * lin.residual;
}

void ReducedSystem::add_gauge(const Eigen::Vector3d& baseline) {
  if (matrix_.size() == 0 || !(gauge_.length > 0)) return;
  const Eigen::Vector3d& u = gauge_.direction;
  if (stale_[0][0]) {
    auto centre = matrix_.column[0].block[0].bottomRightCorner<3, 3>();
    gauge_weight_ = 1e6 * centre.trace();
    centre.noalias() += gauge_weight_ * u * u.transpose();
  }
  if (stale_side_[0])
    right_side_.segment<3>(3) += gauge_weight_ * (gauge_.length - u.dot(baseline)) * u;
}

void ReducedSystem::sum(const PoseIndex& index, std::vector<FilterLandmark>& landmarks,
                        const std::vector<int>& touched, std::vector<FilterEdge>& edges,
                        const Eigen::Vector3d& baseline) {
  const int n = index.num_poses() - 1;
  grow(n);
  for (int l : touched) {
    FilterLandmark& landmark = landmarks[l];
    if (landmark.changed) {
      mark_pairs(landmark, true);
      factor_landmark(landmark);
      landmark.changed = false;
    }
    landmark.step = step_alone(landmark);
    for (const PointMeasurement& m : landmark.measurements) touch_right_side(m.pose);
  }
  for (FilterEdge& edge : edges) {
    if (edge.changed) mark_blocks(edge, true);
    if (edge.moved) touch_right_side(edge.i), touch_right_side(edge.j);
    edge.changed = edge.moved = false;
  }
  num_blocks_summed_ = 0;
  right_side_.conservativeResize(n * kPoseDof);
  for (int a = 0; a < n; ++a) {
    std::fill(matrix_.column[a].changed.begin(), matrix_.column[a].changed.end(), 0);
    if (stale_column_[a]) sum_column(a, index.landmarks(a + 1), landmarks);
    if (stale_side_[a]) sum_right_side(a, index.landmarks(a + 1), landmarks);
  }
  for (const FilterEdge& edge : edges) add_edge(edge);
  add_gauge(baseline);
  for (int a = 0; a < n; ++a)
    if (stale_column_[a]) std::fill(stale_[a].begin(), stale_[a].end(), 0);
  std::fill(stale_column_.begin(), stale_column_.end(), 0);
  std::fill(stale_side_.begin(), stale_side_.end(), 0);
}

}  // namespace eifmap
