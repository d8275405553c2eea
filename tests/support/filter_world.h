// A small simulated world for the filter: points in front of a camera that moves sideways or
// forward, measured with Gaussian noise.
#pragma once

#include <vector>

#include "filter/information_filter.h"
#include "geometry/projection.h"
#include "support/random.h"

namespace eifmap::test {

struct FilterWorldOptions {
  int num_poses = 12, num_points = 150;
  double pixel = 1.0 / 500;  // rad
  double noise_px = 1;
  Eigen::Vector3d step{0.3, 0.02, 0.05};
  double start_error = 0.02;  // of the poses and points that the filter is given, relative
  std::uint64_t seed = 1;
};

struct FilterWorld {
  std::vector<Rigid3> poses;            // true
  std::vector<Eigen::Vector3d> points;  // true
  InformationFilter filter;
  std::vector<int> point_of = {};  // by landmark
};

inline FilterWorld make_filter_world(const FilterWorldOptions& o,
                                     const FilterOptions& options = {}) {
  Random random(o.seed);
  FilterWorld world{{}, {}, InformationFilter(options, o.pixel)};
  const auto noise3 = [&random](double size) {
    return Eigen::Vector3d(size *
                           Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
  };
  for (int p = 0; p < o.num_poses; ++p)
    world.poses.push_back({so3_exp(noise3(0.03) * (p > 0)), p * o.step});
  for (int k = 0; k < o.num_points; ++k) {
    const double along = random.uniform(-1, o.num_poses);
    world.points.push_back(along * o.step + Eigen::Vector3d(random.uniform(-2, 2),
                                                            random.uniform(-2, 2),
                                                            random.uniform(4, 9)));
  }
  for (int p = 0; p < o.num_poses; ++p) {
    // The first baseline is the gauge: both of its ends start true.
    const double error = p < 2 ? 0 : o.start_error;
    world.filter.add_pose(retract(world.poses[p], noise3(0.3 * error), noise3(error)));
  }
  for (std::size_t k = 0; k < world.points.size(); ++k) {
    const Eigen::Vector3d& point = world.points[k];
    std::vector<std::pair<int, Eigen::Vector2d>> seen;
    for (int p = 0; p < o.num_poses; ++p) {
      Eigen::Vector2d x;
      if (project(world.poses[p], point, x) && x.cwiseAbs().maxCoeff() < 0.6)
        seen.emplace_back(
            p, x + o.noise_px * o.pixel * Eigen::Vector2d(random.normal(), random.normal()));
    }
    if (seen.size() < 3) continue;
    const int landmark =
        world.filter.add_landmark(point + noise3(5 * o.start_error), Eigen::Matrix3d::Zero());
    world.point_of.push_back(static_cast<int>(k));
    for (const auto& [p, x] : seen)
      world.filter.add_measurement(landmark, p, x, o.noise_px * o.pixel);
  }
  return world;
}

// The true relative pose of j in i, with independent errors of this variance, rad^2, that it does
// not have.
inline RelativePose true_edge(const FilterWorld& world, int i, int j, double variance) {
  const Rigid3 i_from_j = world.poses[i].inverse() * world.poses[j];
  RelativePose edge;
  edge.i_from_j = i_from_j.rotation;
  edge.direction = i_from_j.translation.normalized();
  edge.covariance = variance * Eigen::Matrix<double, 5, 5>::Identity();
  return edge;
}

// Error of a pose as the filter counts it: (w, dc).
inline Eigen::Matrix<double, 6, 1> pose_error(const Rigid3& truth, const Rigid3& estimate) {
  Eigen::Matrix<double, 6, 1> error;
  error << so3_log(estimate.rotation.conjugate() * truth.rotation),
      truth.translation - estimate.translation;
  return error;
}

}  // namespace eifmap::test
