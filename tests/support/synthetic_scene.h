// Two views of random points, and a map seen by a camera: exact truth, noise and wrong matches.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/rigid3.h"
#include "motion/relative_pose.h"
#include "motion/scale_fit.h"
#include "support/random.h"

namespace eifmap::test {

// A pinhole camera of 640 x 480 px: 65 degrees wide.
inline constexpr double kFocal = 500, kHalfWidth = 320, kHalfHeight = 240;  // px
inline constexpr double kRadiansPerPixel = 1 / kFocal;

// Anywhere in the image, normalized coordinates.
inline Eigen::Vector2d random_in_image(Random& random) {
  return {random.uniform(-kHalfWidth, kHalfWidth) / kFocal,
          random.uniform(-kHalfHeight, kHalfHeight) / kFocal};
}

inline bool in_image(const Eigen::Vector3d& in_camera) {
  return in_camera.z() > 0.1 && std::abs(in_camera.x()) < kHalfWidth / kFocal * in_camera.z() &&
         std::abs(in_camera.y()) < kHalfHeight / kFocal * in_camera.z();
}

struct SceneOptions {
  int number = 150;
  double outliers = 0;    // share of wrong matches, uniform over the image
  double noise_px = 0.7;  // per axis and image
  double sigma_px = 0.7;  // what the matches claim
  double near = 4, far = 20;
  bool plane = false;  // all on one slanted wall
};

// A point in front of `i`, in its frame.
inline Eigen::Vector3d random_point(const SceneOptions& options, Random& random) {
  const Eigen::Vector2d x = random_in_image(random);
  double depth = random.uniform(options.near, options.far);
  // The wall n.x = middle with n = (.4, .2, 1).
  if (options.plane) depth = 0.5 * (options.near + options.far) / (0.4 * x.x() + 0.2 * x.y() + 1);
  return depth * x.homogeneous();
}

struct TwoViews {
  Rigid3 i_from_j;
  std::vector<Correspondence> matches;
  std::vector<std::uint8_t> right;  // 0: a wrong match
};

inline TwoViews two_views(const Rigid3& i_from_j, const SceneOptions& options, std::uint64_t seed) {
  Random random(seed);
  TwoViews views{i_from_j, {}, {}};
  const double noise = options.noise_px * kRadiansPerPixel;
  const double sigma = options.sigma_px * kRadiansPerPixel;
  const Rigid3 j_from_i = i_from_j.inverse();
  while (static_cast<int>(views.matches.size()) < options.number) {
    const Eigen::Vector3d in_i = random_point(options, random), in_j = j_from_i * in_i;
    if (!in_image(in_j)) continue;
    const bool right = random.uniform() >= options.outliers;
    const Eigen::Vector2d x_j =
        right ? Eigen::Vector2d(in_j.hnormalized() + noise * random.normal_vector<2>())
              : random_in_image(random);
    views.matches.push_back(
        {in_i.hnormalized() + noise * random.normal_vector<2>(), x_j, sigma, sigma});
    views.right.push_back(right);
  }
  return views;
}

// A map in front of `world_from_camera`, seen by it.
inline std::vector<MapObservation> map_view(const Rigid3& world_from_camera,
                                            const SceneOptions& options, std::uint64_t seed) {
  Random random(seed);
  std::vector<MapObservation> observations;
  const double noise = options.noise_px * kRadiansPerPixel;
  const double sigma = options.sigma_px * kRadiansPerPixel;
  for (int k = 0; k < options.number; ++k) {
    const Eigen::Vector3d in_camera = random_point(options, random);
    const bool right = random.uniform() >= options.outliers;
    const Eigen::Vector2d x =
        right ? Eigen::Vector2d(in_camera.hnormalized() + noise * random.normal_vector<2>())
              : random_in_image(random);
    observations.push_back({world_from_camera * in_camera, x, sigma});
  }
  return observations;
}

// Angle between two unit vectors, rad.
inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Coordinates ab with sphere_retract(from, ab) = to.
inline Eigen::Vector2d sphere_local(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector2d flat = sphere_basis(from).transpose() * to;
  const double length = flat.norm();
  return length < 1e-12 ? flat : Eigen::Vector2d(angle_between(from, to) / length * flat);
}

// rad, of the direction.
inline double direction_error(const RelativePose& pose, const TwoViews& views) {
  return angle_between(pose.direction, views.i_from_j.translation.normalized());
}

// What the pose lacks to the truth, (w, ab).
inline Eigen::Matrix<double, 5, 1> error_of(const RelativePose& pose, const TwoViews& views) {
  Eigen::Matrix<double, 5, 1> error;
  error << so3_log(pose.i_from_j.conjugate() * views.i_from_j.rotation),
      sphere_local(pose.direction, views.i_from_j.translation.normalized());
  return error;
}

// Squared error in units of the claimed covariance; 5 on average if that is honest.
inline double nees(const RelativePose& pose, const TwoViews& views) {
  const Eigen::Matrix<double, 5, 1> error = error_of(pose, views);
  return error.dot(pose.covariance.llt().solve(error));
}

}  // namespace eifmap::test
