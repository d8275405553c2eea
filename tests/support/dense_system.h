// The filter's information matrix formed whole, as an oracle.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "filter/information_filter.h"

namespace eifmap::test {

// The whole information matrix over poses (but the first) and landmarks, summed measurement by
// measurement as [WD10] (7) says, with nothing eliminated; and the gradient at the mean.
struct Dense {
  Eigen::MatrixXd information;
  Eigen::VectorXd right_side;
  int pose_size = 0;  // landmarks begin there

  double scale() const { return information.diagonal().norm(); }
};

inline Dense dense_system(const InformationFilter& filter) {
  const int num_landmarks = filter.num_landmarks();
  const PoseBlocks& blocks = filter.blocks();
  const int n = 6 * blocks.count(filter.num_poses()), size = n + 3 * num_landmarks;
  Dense dense{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), n};
  for (int l = 0; l < num_landmarks; ++l) {
    for (const PointMeasurement& m : filter.landmark(l).measurements) {
      Eigen::MatrixXd h = Eigen::MatrixXd::Zero(2, size);
      if (m.pose > 0) h.middleCols<6>(6 * blocks.of(m.pose)) = m.d_pose();
      h.middleCols<3>(n + 3 * l) = m.frozen.to_landmark;
      dense.information += h.transpose() * h;
      if (m.pose > 0) h.middleCols<6>(6 * blocks.of(m.pose)) = m.d_pose_now();
      h.middleCols<3>(n + 3 * l) = m.now.to_landmark;
      dense.right_side += h.transpose() * m.residual;
    }
  }
  for (const FilterEdge& edge : filter.edges()) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(5, size);
    if (edge.i > 0) h.middleCols<6>(6 * blocks.of(edge.i)) = edge.frozen.d_i;
    if (edge.j > 0) h.middleCols<6>(6 * blocks.of(edge.j)) = edge.frozen.d_j;
    dense.information += h.transpose() * h;
    if (edge.i > 0) h.middleCols<6>(6 * blocks.of(edge.i)) = edge.now.d_i;
    if (edge.j > 0) h.middleCols<6>(6 * blocks.of(edge.j)) = edge.now.d_j;
    dense.right_side += h.transpose() * edge.now.residual;
  }
  if (blocks.has_earth())  // the prior of its orientation
    dense.information.diagonal().segment<3>(6 * blocks.earth()).array() +=
        1 / std::pow(kEarthPrior, 2);
  if (const Eigen::Vector3d& up = filter.held_up(); !up.isZero(0)) {  // and what is by definition
    const double weight = std::pow(kByDefinition, -2);
    dense.information.block<3, 3>(6 * blocks.earth(), 6 * blocks.earth()) +=
        weight * up * up.transpose();
    dense.information.diagonal().segment<3>(6 * blocks.earth() + 3).array() += weight;
  }
  for (const FilterAbsolute& absolute : filter.absolutes()) {
    for (const auto* rows : {&absolute.frozen, &absolute.now}) {
      Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3, size);
      for (const PoseRows& of_pose : rows->of_pose)
        if (of_pose.pose != 0) h.middleCols<6>(6 * blocks.of(of_pose.pose)) += of_pose.derivative;
      if (rows == &absolute.frozen) dense.information += h.transpose() * h;
      if (rows == &absolute.now) dense.right_side += h.transpose() * rows->residual;
    }
  }
  return dense;
}

// What is left of the right side once the gauge's direction, which may keep some, is taken out.
inline Eigen::VectorXd pose_right_side(const InformationFilter& filter,
                                       const Eigen::Vector3d& gauge_direction) {
  const Dense dense = dense_system(filter);
  Eigen::VectorXd right_side = dense.right_side;
  const Eigen::Vector3d u = gauge_direction.normalized();
  right_side.segment<3>(3) -= u * u.dot(right_side.segment<3>(3));
  return right_side;
}

// The inverse of the whole matrix with the scale held unless the map is metric, times what the
// filter allows for correlated errors: all covariances at once. Every landmark must be seen.
inline Eigen::MatrixXd dense_covariance(const InformationFilter& filter,
                                        const Eigen::Vector3d& gauge_direction) {
  using Exact = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Exact information = dense_system(filter).information.cast<long double>();
  if (!filter.is_metric()) {
    // As firmly as the filter does: of what is left of the second pose's block without landmarks.
    const Eigen::Index n = 6 * filter.blocks().count(filter.num_poses());
    const Eigen::Index points = information.rows() - n;
    const Exact across = information.bottomRows(points).middleCols(3, 3);
    const Exact left =
        information.block(3, 3, 3, 3) -
        across.transpose() * information.bottomRightCorner(points, points).ldlt().solve(across);
    const Eigen::Vector3d u = gauge_direction.normalized();
    information.block(3, 3, 3, 3) +=
        1e6L * left.trace() * (u * u.transpose()).cast<long double>().eval();
  }
  const auto size = information.rows();
  return filter.correlation().variance_factor() *
         information.ldlt().solve(Exact::Identity(size, size)).cast<double>().eval();
}

}  // namespace eifmap::test
