#include "filter/reduced_system.h"

#include <algorithm>
#include <cmath>

#include "vector_clones.h"

namespace eifmap {
namespace {

// What a landmark's elimination takes off the poses' matrix: of the blocks of two poses that see
// it, rows' rows.
struct Elimination {
  int block = 0;  // of its pose
  bool stale = false;
  Eigen::Matrix<double, 3, 6, Eigen::RowMajor> rows;  // Q'd_pose
};

// block -= other' own, by rows.
struct Product {
  const Elimination* other = nullptr;
  PoseBlock* block = nullptr;
};

// Four numbers of a block at once: two of its columns are three such vectors.
EIFMAP_VECTOR_CLONES
void take_off(const Elimination& own, const Product* products, std::size_t count) {
  using Four = double __attribute__((vector_size(32), aligned(8), may_alias));
  constexpr int kFours = 9;  // of a block
  Four factor[3][kFours];
  for (int r = 0; r < 3; ++r)
    for (int v = 0; v < kFours; ++v)
      for (int k = 0; k < 4; ++k) factor[r][v][k] = own.rows(r, (4 * v + k) / kPoseDof);
  for (std::size_t n = 0; n < count; ++n) {
    const double* row = products[n].other->rows.data();
    Four sum[kFours] = {};
    for (int r = 0; r < 3; ++r, row += kPoseDof) {
      const Four other[3] = {{row[0], row[1], row[2], row[3]},
                             {row[4], row[5], row[0], row[1]},
                             {row[2], row[3], row[4], row[5]}};
      for (int v = 0; v < kFours; ++v) sum[v] += other[v % 3] * factor[r][v];
    }
    Four* block = reinterpret_cast<Four*>(products[n].block->data());
    for (int v = 0; v < kFours; ++v) block[v] -= sum[v];
  }
}

}  // namespace

Eigen::Vector3d step_alone_in_sigmas(const FilterLandmark& landmark) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (const PointMeasurement& m : landmark.measurements)
    gradient.noalias() += m.now.to_landmark.transpose() * m.residual;
  return landmark.r_inverse.transpose() * gradient;
}

// By Gram-Schmidt, twice. A trace of damping keeps V from being singular, and is far below any
// information that a sighting brings.
void factor_landmark(FilterLandmark& landmark) {
  const auto m = static_cast<Eigen::Index>(landmark.measurements.size());
  thread_local Eigen::Matrix<double, Eigen::Dynamic, 3> q;
  q.resize(2 * m + 3, 3);
  for (Eigen::Index k = 0; k < m; ++k)
    q.middleRows<2>(2 * k) = landmark.measurements[static_cast<std::size_t>(k)].frozen.to_landmark;
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
    matrix_.append();
    matrix_.write(a).insert(a);
    stale_column_.push_back(1);
    stale_side_.push_back(1);
    removed_.push_back(0);
  }
}

// The block of two poses is to be summed again. What came and went between two sums is in no
// column, and need not be.
void ReducedSystem::mark(int pose, int other, bool may_insert) {
  const int p = blocks_.of(pose), q = blocks_.of(other);
  const int a = std::max(p, q), b = std::min(p, q);
  if (b < 0 || a >= matrix_.size()) return;
  const int at = matrix_.column(a).find(b);
  if (at < 0 && !may_insert) return;
  if (at < 0)
    matrix_.write(a).insert(b);
  else if (!matrix_.column(a).stale[at])
    matrix_.write(a).stale[at] = 1;
  stale_column_[a] = 1;
}

void ReducedSystem::touch_right_side(int pose) {
  const int block = blocks_.of(pose);
  if (block >= 0 && block < matrix_.size()) stale_side_[block] = 1;
}

void ReducedSystem::touch_right_side(const FilterAbsolute& absolute) {
  for (const PoseRows& rows : absolute.now.of_pose) touch_right_side(rows.pose);
}

void ReducedSystem::set_gauge(const ScaleGauge& gauge) {
  gauge_ = gauge;
  mark(1, 1, false);
  touch_right_side(1);
}

void ReducedSystem::hold_earth(const Eigen::Vector3d& up) {
  held_up_ = up;
  mark(kEarthFromMap, kEarthFromMap, false);
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

void ReducedSystem::mark_blocks(const FilterAbsolute& absolute, bool may_insert) {
  const std::vector<PoseRows>& rows = absolute.frozen.of_pose;
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t l = 0; l <= k; ++l) mark(rows[k].pose, rows[l].pose, may_insert);
  touch_right_side(absolute);
}

void ReducedSystem::before_removal(const FilterAbsolute& absolute) {
  mark_blocks(absolute, false);
}

void ReducedSystem::before_removal(const FilterLandmark& landmark) {
  mark_pairs(landmark, false);
}

void ReducedSystem::before_removal(const FilterEdge& edge) {
  mark_blocks(edge, false);
}

void ReducedSystem::remove(int pose) {
  const int a = blocks_.of(pose);
  grow(a + 1);
  BlockColumn& own = matrix_.write(a);
  while (own.row.size() > 1) own.erase(0);
  own.stale.back() = 1;
  for (int other = a + 1; other < matrix_.size(); ++other)
    if (const int at = matrix_.column(other).find(a); at >= 0) matrix_.write(other).erase(at);
  removed_[a] = 1;
  ++num_removed_;
  stale_column_[a] = stale_side_[a] = 1;
}

bool ReducedSystem::drop_removed(int num_poses) {
  constexpr int kMany = 16, kShare = 4;  // as many, and a part of those in use
  grow(blocks_.count(num_poses));
  const int in_use = matrix_.size() - num_removed_;
  if (num_removed_ < kMany || kShare * num_removed_ < in_use) return false;
  right_side_.conservativeResizeLike(Eigen::VectorXd::Zero(matrix_.size() * kPoseDof));
  const std::vector<int> now = blocks_.renumber(num_poses, removed_);
  matrix_ = matrix_.renumbered(now);
  for (std::size_t b = 0; b < now.size(); ++b) {
    if (now[b] < 0) continue;
    stale_column_[now[b]] = stale_column_[b];
    stale_side_[now[b]] = stale_side_[b];
    right_side_.segment<kPoseDof>(kPoseDof * now[b]) =
        right_side_.segment<kPoseDof>(kPoseDof * static_cast<Eigen::Index>(b)).eval();
  }
  stale_column_.resize(in_use);
  stale_side_.resize(in_use);
  right_side_.conservativeResize(in_use * kPoseDof);
  removed_.assign(in_use, 0);
  num_removed_ = 0;
  return true;
}

void ReducedSystem::clear_stale_blocks(int a) {
  BlockColumn& column = matrix_.write(a);
  for (std::size_t k = 0; k < column.row.size(); ++k) {
    if (!column.stale[k]) continue;
    column.block[k].setZero();
    column.changed[k] = 1;
    ++num_blocks_summed_;
  }
}

// The stale blocks of its sights' columns: each sight with all.
void ReducedSystem::add_landmark(const FilterLandmark& landmark) {
  thread_local std::vector<Elimination> all;
  thread_local std::vector<Product> products;
  const std::vector<PointMeasurement>& measurements = landmark.measurements;
  all.resize(measurements.size());
  bool any = false;
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    all[k].block = blocks_.of(measurements[k].pose);
    all[k].stale = all[k].block >= 0 && stale_column_[all[k].block];
    any = any || all[k].stale;
  }
  if (!any) return;
  for (std::size_t k = 0; k < measurements.size(); ++k)
    all[k].rows.noalias() = measurements[k].q.transpose() * measurements[k].d_pose();
  for (std::size_t own = 0; own < measurements.size(); ++own) {
    if (!all[own].stale) continue;
    BlockColumn& column = *stale_columns_[all[own].block];
    products.clear();
    for (const Elimination& other : all) {
      if (other.block < 0 || other.block > all[own].block) continue;
      const int at = column.find(other.block);
      if (column.stale[at]) products.push_back({&other, &column.block[at]});
    }
    if (column.stale.back()) {
      const SightDerivative d_pose = measurements[own].d_pose();
      column.block.back().noalias() += d_pose.transpose() * d_pose;
    }
    take_off(all[own], products.data(), products.size());
  }
}

// What is left for the poses once the landmark is eliminated.
void ReducedSystem::add_right_side(const FilterLandmark& landmark) {
  for (const PointMeasurement& m : landmark.measurements) {
    const int block = blocks_.of(m.pose);
    if (block < 0 || !stale_side_[block]) continue;
    const Eigen::Vector2d left = m.residual - m.now.to_landmark * landmark.step;
    right_side_.segment<6>(6 * block).noalias() += m.d_pose_now().transpose() * left;
  }
}

// The block of S to add to; none where it is not to be summed.
PoseBlock* ReducedSystem::stale_block(int i, int j) {
  const int p = blocks_.of(i), q = blocks_.of(j);
  const int a = std::max(p, q), b = std::min(p, q);
  if (b < 0 || !stale_column_[a]) return nullptr;
  const int at = matrix_.column(a).find(b);
  return matrix_.column(a).stale[at] ? &matrix_.write(a).block[at] : nullptr;
}

void ReducedSystem::add_edge(const FilterEdge& edge) {
  const RelativePoseLinearization &frozen = edge.frozen, &now = edge.now;
  if (PoseBlock* block = stale_block(edge.i, edge.i))
    block->noalias() += frozen.d_i.transpose() * frozen.d_i;
  if (PoseBlock* block = stale_block(edge.j, edge.j))
    block->noalias() += frozen.d_j.transpose() * frozen.d_j;
  if (PoseBlock* block = stale_block(edge.i, edge.j)) {
    const bool upper = edge.i < edge.j;
    block->noalias() +=
        (upper ? frozen.d_i : frozen.d_j).transpose() * (upper ? frozen.d_j : frozen.d_i);
  }
  const int i = blocks_.of(edge.i), j = blocks_.of(edge.j);
  if (i >= 0 && stale_side_[i])
    right_side_.segment<6>(6 * i).noalias() += now.d_i.transpose() * now.residual;
  if (j >= 0 && stale_side_[j])
    right_side_.segment<6>(6 * j).noalias() += now.d_j.transpose() * now.residual;
}

void ReducedSystem::add_absolute(const FilterAbsolute& absolute) {
  const std::vector<PoseRows>& frozen = absolute.frozen.of_pose;
  for (std::size_t k = 0; k < frozen.size(); ++k)
    for (std::size_t l = 0; l <= k; ++l) {
      PoseBlock* block = stale_block(frozen[k].pose, frozen[l].pose);
      if (!block) continue;
      const bool in_order = blocks_.of(frozen[l].pose) <= blocks_.of(frozen[k].pose);
      const PoseRows &upper = frozen[in_order ? l : k], &lower = frozen[in_order ? k : l];
      block->noalias() += upper.derivative.transpose() * lower.derivative;
    }
  for (const PoseRows& now : absolute.now.of_pose) {
    const int block = blocks_.of(now.pose);
    if (block < 0 || !stale_side_[block]) continue;
    right_side_.segment<6>(6 * block).noalias() +=
        now.derivative.transpose() * absolute.now.residual;
  }
}

// Where all positions lie on a line nothing but noise says how earth is turned about it, and steps
// of the mean would turn it on and on. So it counts as known to half a radian, in the matrix alone:
// that pulls at nothing, and beside the first position off the line it weighs little.
void ReducedSystem::add_earth_prior() {
  if (!blocks_.has_earth()) return;
  PoseBlock* block = stale_block(kEarthFromMap, kEarthFromMap);
  if (!block) return;
  block->diagonal().head<3>().array() += 1 / (kEarthPrior * kEarthPrior);
  if (held_up_.isZero(0)) return;
  constexpr double kWeight = 1 / (kByDefinition * kByDefinition);
  block->topLeftCorner<3, 3>() += kWeight * held_up_ * held_up_.transpose();
  block->diagonal().tail<3>().array() += kWeight;
}

void ReducedSystem::add_gauge(const Eigen::Vector3d& baseline) {
  if (matrix_.size() == 0 || !(gauge_.length > 0)) return;
  const Eigen::Vector3d& u = gauge_.direction;
  if (matrix_.column(0).stale[0]) {
    auto centre = matrix_.write(0).block[0].bottomRightCorner<3, 3>();
    gauge_weight_ = 1e6 * centre.trace();
    centre.noalias() += gauge_weight_ * u * u.transpose();
  }
  if (stale_side_[0])
    right_side_.segment<3>(3) += gauge_weight_ * (gauge_.length - u.dot(baseline)) * u;
}

void ReducedSystem::sum(const PoseIndex& index, FilterLandmarks& landmarks,
                        const std::vector<int>& touched, FilterEdges& edges,
                        std::vector<FilterAbsolute>& absolutes, const Eigen::Vector3d& baseline) {
  const int n = blocks_.count(index.num_poses());
  grow(n);
  largest_step_alone_ = 0;
  for (int l : touched) {
    if (landmarks[l].is_removed()) continue;
    FilterLandmark& landmark = landmarks.write(l);
    if (landmark.changed) {
      mark_pairs(landmark, true);
      factor_landmark(landmark);
      landmark.changed = false;
    }
    const Eigen::Vector3d sigmas = step_alone_in_sigmas(landmark);
    landmark.step = landmark.r_inverse * sigmas;
    largest_step_alone_ = std::max(largest_step_alone_, sigmas.norm());
    for (const PointMeasurement& m : landmark.measurements) touch_right_side(m.pose);
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (!edges[e].changed && !edges[e].moved) continue;
    FilterEdge& edge = edges.write(e);
    if (edge.changed) mark_blocks(edge, true);
    if (edge.moved) touch_right_side(edge.i), touch_right_side(edge.j);
    edge.changed = edge.moved = false;
  }
  for (FilterAbsolute& absolute : absolutes) {
    if (absolute.changed) mark_blocks(absolute, true);
    if (absolute.moved) touch_right_side(absolute);
    absolute.changed = absolute.moved = false;
  }
  num_blocks_summed_ = 0;
  right_side_.conservativeResize(n * kPoseDof);
  stale_columns_.resize(n);
  for (int a = 0; a < n; ++a) {
    if (stale_column_[a]) clear_stale_blocks(a);
    stale_columns_[a] = stale_column_[a] ? &matrix_.write(a) : nullptr;
    if (stale_column_[a] && removed_[a]) matrix_.write(a).block.back().setIdentity();
    if (stale_side_[a]) right_side_.segment<6>(6 * a).setZero();
    if (!stale_column_[a] && !stale_side_[a]) continue;
    if (const int pose = blocks_.pose(a); pose != kEarthFromMap)
      for (int l : index.landmarks(pose)) concerned_.insert(l);
  }
  // Landmark by landmark: what one of them says of all its poses lies together.
  for (int l : concerned_.sorted()) {
    add_landmark(landmarks[l]);
    add_right_side(landmarks[l]);
  }
  concerned_.clear();
  for (const FilterEdge& edge : edges) add_edge(edge);
  for (const FilterAbsolute& absolute : absolutes) add_absolute(absolute);
  add_earth_prior();
  add_gauge(baseline);
  for (int a = 0; a < n; ++a) {
    if (!stale_column_[a]) continue;
    std::vector<std::uint8_t>& stale = stale_columns_[a]->stale;
    std::fill(stale.begin(), stale.end(), 0);
  }
  std::fill(stale_column_.begin(), stale_column_.end(), 0);
  std::fill(stale_side_.begin(), stale_side_.end(), 0);
  stale_columns_.clear();
}

}  // namespace eifmap
