// What the information matrix is made of, formed whole over all poses and landmarks.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "support/filter_world.h"

namespace eifmap::test {
namespace {

// Without any gauge: the first pose has its six rows as the others.
Eigen::MatrixXd whole_information(const InformationFilter& filter) {
  const int n = 6 * filter.num_poses();
  Eigen::MatrixXd information =
      Eigen::MatrixXd::Zero(n + 3 * filter.num_landmarks(), n + 3 * filter.num_landmarks());
  const auto add = [&information](const Eigen::MatrixXd& h) { information += h.transpose() * h; };
  for (int l = 0; l < filter.num_landmarks(); ++l)
    for (const PointMeasurement& m : filter.landmark(l).measurements) {
      Eigen::MatrixXd h = Eigen::MatrixXd::Zero(2, information.cols());
      h.middleCols<6>(6 * m.pose) = m.d_pose();
      h.middleCols<3>(n + 3 * l) = m.frozen.to_landmark;
      add(h);
    }
  for (const FilterEdge& edge : filter.edges()) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(5, information.cols());
    h.middleCols<6>(6 * edge.i) = edge.frozen.d_i;
    h.middleCols<6>(6 * edge.j) = edge.frozen.d_j;
    add(h);
  }
  return information;
}

FilterWorld world_with_edge(double noise_px) {
  FilterOptions always;
  always.relinearize = Relinearize::kAlways;
  always.max_iterations = 20;
  FilterWorld world = make_filter_world(
      {.num_poses = 5, .num_points = 40, .noise_px = noise_px, .seed = 23}, always);
  EXPECT_TRUE(world.filter.add_edge(1, 3, true_edge(world, 1, 3, 1e-4)));
  EXPECT_EQ(world.filter.update().reason, Reason::kNone);
  return world;
}

TEST(InformationStructure, IsExactlySparse) {
  const FilterWorld world = world_with_edge(1);
  const InformationFilter& filter = world.filter;
  const Eigen::MatrixXd information = whole_information(filter);
  const int n = 6 * filter.num_poses();
  for (int i = 0; i < filter.num_poses(); ++i)
    for (int j = 0; j < i; ++j)
      EXPECT_EQ((information.block<6, 6>(6 * i, 6 * j).isZero(0)), i != 3 || j != 1) << i << j;
  for (int k = 0; k < filter.num_landmarks(); ++k) {
    for (int l = 0; l < k; ++l)
      EXPECT_TRUE((information.block<3, 3>(n + 3 * k, n + 3 * l).isZero(0))) << k << ' ' << l;
    std::vector<bool> seen(static_cast<std::size_t>(filter.num_poses()), false);
    for (const PointMeasurement& m : filter.landmark(k).measurements)
      seen[static_cast<std::size_t>(m.pose)] = true;
    for (int p = 0; p < filter.num_poses(); ++p)
      EXPECT_EQ((information.block<3, 6>(n + 3 * k, 6 * p).isZero(0)),
                !seen[static_cast<std::size_t>(p)]);
  }
}

TEST(InformationStructure, LacksSevenDegreesOfFreedomWithoutPriors) {
  // All Jacobians at one point, which is where nothing moves any more.
  const FilterWorld world = world_with_edge(1e-4);
  Eigen::MatrixXd information = whole_information(world.filter);
  // Rows of very different units: brought to a unit diagonal, which leaves the rank.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  information = (scale.asDiagonal() * information * scale.asDiagonal()).eval();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(information).eigenvalues();
  EXPECT_LT(values[6], 1e-9);
  EXPECT_GT(values[7], 1e3 * std::abs(values[6]));
  EXPECT_GT(values[7], 1e-7);
}

}  // namespace
}  // namespace eifmap::test
