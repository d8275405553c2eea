// Similarity transforms that agree as well as they can.
#include "map/pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/random.h"

namespace eifmap::test {
namespace {

Eigen::Vector3d noise3(Random& random, double size) {
  return size * random.normal_vector<3>();
}

Similarity random_similarity(Random& random) {
  return Similarity::of({so3_exp(noise3(random, 0.8)), noise3(random, 3)},
                        std::exp(0.3 * random.normal()));
}

double distance(const Similarity& a, const Similarity& b) {
  return (a.translation - b.translation).norm() + (a.rotation - b.rotation).norm() +
         std::abs(std::log(a.scale / b.scale));
}

PoseGraphEdge edge_of(const std::vector<Similarity>& nodes, int i, int j) {
  return {i, j, nodes[i].inverse() * nodes[j], 0.01, 0.05, 0.02};
}

TEST(Similarity, IsAGroup) {
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const Similarity a = random_similarity(random), b = random_similarity(random);
    const Eigen::Vector3d x = noise3(random, 5);
    EXPECT_NEAR(((a * b) * x - a * (b * x)).norm(), 0, 1e-12);
    EXPECT_NEAR((a.inverse() * (a * x) - x).norm(), 0, 1e-12);
  }
}

// Whatever the nodes start from, edges without errors bring them to the truth.
TEST(PoseGraph, FindsTheTruthFromEdgesWithoutErrors) {
  Random random(5);
  std::vector<Similarity> truth;
  for (int k = 0; k < 12; ++k) truth.push_back(random_similarity(random));
  PoseGraph graph;
  for (int k = 0; k < 12; ++k) {
    graph.nodes.push_back(truth[k] * Similarity::of({so3_exp(noise3(random, k == 0 ? 0 : 0.15)),
                                                     noise3(random, k == 0 ? 0 : 0.3)},
                                                    std::exp(k == 0 ? 0 : 0.2 * random.normal())));
    graph.held.push_back(k == 0);
    if (k > 0) graph.edges.push_back(edge_of(truth, k - 1, k));
    if (k > 2) graph.edges.push_back(edge_of(truth, k, k - 3));
  }
  const PoseGraphSolution solution = solve(graph);
  EXPECT_TRUE(solution.ok);
  EXPECT_GT(solution.cost_before, 1);
  EXPECT_LT(solution.cost_after, 1e-9);
  for (int k = 0; k < 12; ++k) EXPECT_LT(distance(graph.nodes[k], truth[k]), 1e-6) << k;
}

// A round way whose scale and heading drift: the loop takes off what has gathered, and spreads it.
TEST(PoseGraph, TakesTheDriftOffALoop) {
  constexpr int kNodes = 200;
  std::vector<Similarity> truth;
  for (int k = 0; k <= kNodes; ++k) {
    const double angle = 2 * std::numbers::pi * k / kNodes;
    truth.push_back(Similarity::of(
        {so3_exp({0, -angle, 0}), {30 * (std::cos(angle) - 1), 0, 30 * std::sin(angle)}}));
  }
  PoseGraph graph;
  graph.nodes = {truth[0]};
  graph.held.assign(kNodes + 1, 0);
  graph.held[0] = 1;
  const Similarity drift = Similarity::of({so3_exp({0, 0.0005, 0}), {0, 0, 0}}, 1.001);
  for (int k = 1; k <= kNodes; ++k) {
    PoseGraphEdge edge = edge_of(truth, k - 1, k);
    edge.i_from_j = edge.i_from_j * drift;
    graph.nodes.push_back(graph.nodes[k - 1] * edge.i_from_j);
    graph.edges.push_back(edge);
  }
  const auto worst = [&] {
    double most = 0;
    for (int k = 0; k <= kNodes; ++k)
      most = std::max(most, (graph.nodes[k].translation - truth[k].translation).norm());
    return most;
  };
  const double before = worst();
  PoseGraphEdge loop = edge_of(truth, 0, kNodes);
  loop.sigma_rotation = loop.sigma_translation = loop.sigma_scale = 1e-3;
  graph.edges.push_back(loop);
  EXPECT_TRUE(solve(graph).ok);
  EXPECT_GT(before, 5);
  EXPECT_LT(worst(), 0.3 * before);
  EXPECT_LT(distance(graph.nodes[kNodes], truth[kNodes]), 0.05);
}

TEST(PoseGraph, SaysWhatHangsOnNothing) {
  Random random(2);
  PoseGraph graph;
  for (int k = 0; k < 4; ++k) graph.nodes.push_back(random_similarity(random));
  graph.held = {1, 0, 0, 0};
  graph.edges = {edge_of(graph.nodes, 0, 1), edge_of(graph.nodes, 2, 3)};
  EXPECT_FALSE(solve(graph).ok);
  graph.held[3] = 1;
  EXPECT_TRUE(solve(graph).ok);
}

TEST(PoseGraph, RefusesWhatMakesNoSense) {
  Random random(2);
  PoseGraph graph;
  graph.nodes = {random_similarity(random), random_similarity(random)};
  graph.held = {1, 0};
  graph.edges = {edge_of(graph.nodes, 0, 1)};
  PoseGraph other = graph;
  other.edges[0].j = 2;
  EXPECT_THROW(solve(other), std::invalid_argument);
  other = graph;
  other.edges[0].sigma_scale = 0;
  EXPECT_THROW(solve(other), std::invalid_argument);
  other = graph;
  other.held.pop_back();
  EXPECT_THROW(solve(other), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
