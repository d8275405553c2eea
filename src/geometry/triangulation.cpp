#include "geometry/triangulation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/projection.h"

namespace eifmap {
namespace {

// Viewing rays in world, unit.
std::vector<Eigen::Vector3d> viewing_rays(std::span<const Sighting> sightings) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(sightings.size());
  for (const Sighting& s : sightings)
    rays.push_back((s.world_from_camera.rotation * s.x.homogeneous()).normalized());
  return rays;
}

struct Pair {
  std::size_t a = 0, b = 0;
  double parallax = 0;  // rad
};

Pair widest_pair(const std::vector<Eigen::Vector3d>& rays) {
  Pair widest;
  for (std::size_t a = 0; a < rays.size(); ++a)
    for (std::size_t b = a + 1; b < rays.size(); ++b) {
      // The cross product keeps small angles exact where an arc cosine would lose them.
      const double parallax = std::atan2(rays[a].cross(rays[b]).norm(), rays[a].dot(rays[b]));
      if (parallax > widest.parallax) widest = {a, b, parallax};
    }
  return widest;
}

// Halfway between the closest points of two rays. False when they do not converge in front.
bool midpoint(const Eigen::Vector3d& centre_a, const Eigen::Vector3d& ray_a,
              const Eigen::Vector3d& centre_b, const Eigen::Vector3d& ray_b,
              Eigen::Vector3d& point) {
  const Eigen::Vector3d baseline = centre_b - centre_a;
  const double sin2 = ray_a.cross(ray_b).squaredNorm();
  if (!(sin2 > 1e-18)) return false;
  const double cosine = ray_a.dot(ray_b), along_a = ray_a.dot(baseline),
               along_b = ray_b.dot(baseline);
  const double depth_a = (along_a - cosine * along_b) / sin2;
  const double depth_b = (cosine * along_a - along_b) / sin2;
  if (!(depth_a > 0 && depth_b > 0)) return false;
  point = 0.5 * (centre_a + depth_a * ray_a + centre_b + depth_b * ray_b);
  return true;
}

struct Normal {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double cost = 0;  // sum of squared whitened errors
  double max_squared_error = 0;
};

// False when the point is behind a view.
bool linearize(std::span<const Sighting> sightings, const std::vector<Projector>& views,
               const Eigen::Vector3d& point, Normal& normal) {
  normal = {};
  for (std::size_t i = 0; i < views.size(); ++i) {
    Eigen::Vector2d x;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!views[i](point, x, nullptr, &jacobian)) return false;
    const double weight = 1 / (sightings[i].sigma * sightings[i].sigma);
    const Eigen::Vector2d error = sightings[i].x - x;
    normal.information.noalias() += weight * jacobian.transpose() * jacobian;
    normal.gradient.noalias() += weight * jacobian.transpose() * error;
    const double squared = weight * error.squaredNorm();
    normal.cost += squared;
    normal.max_squared_error = std::max(normal.max_squared_error, squared);
  }
  return true;
}

// Levenberg-Marquardt; `normal` is that of the point found. False when it never settles.
bool refine(std::span<const Sighting> sightings, Eigen::Vector3d& point, Normal& normal) {
  std::vector<Projector> views;
  views.reserve(sightings.size());
  for (const Sighting& s : sightings) views.emplace_back(s.world_from_camera);
  if (!linearize(sightings, views, point, normal)) return false;

  double damping = 1e-6;
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::Matrix3d damped = normal.information;
    damped.diagonal() *= 1 + damping;
    const Eigen::Vector3d step = damped.ldlt().solve(normal.gradient);
    if (!step.allFinite()) return false;
    // Settled: the step is far below the point's own standard deviation.
    if (step.dot(normal.information * step) < 1e-10) return true;
    Normal moved;
    if (linearize(sightings, views, point + step, moved) && moved.cost <= normal.cost) {
      point += step;
      normal = moved;
      damping = std::max(1e-9, damping / 10);
    } else {
      damping *= 10;
      if (damping > 1e8) return false;
    }
  }
  return false;
}

}  // namespace

TriangulatedPoint triangulate(std::span<const Sighting> sightings) {
  TriangulatedPoint result;
  if (sightings.size() < 2) return result;
  for (const Sighting& s : sightings)
    if (!(s.sigma > 0) || !s.x.allFinite()) return result;

  const std::vector<Eigen::Vector3d> rays = viewing_rays(sightings);
  const Pair widest = widest_pair(rays);
  result.max_parallax = widest.parallax;
  const Eigen::Vector3d& centre_a = sightings[widest.a].world_from_camera.translation;
  const Eigen::Vector3d& centre_b = sightings[widest.b].world_from_camera.translation;
  Normal normal;
  if (!midpoint(centre_a, rays[widest.a], centre_b, rays[widest.b], result.point)) return result;
  if (!refine(sightings, result.point, normal)) return result;

  const Eigen::LLT<Eigen::Matrix3d> factor(normal.information);
  if (factor.info() != Eigen::Success || !(factor.rcond() > 1e-14)) return result;
  result.covariance = factor.solve(Eigen::Matrix3d::Identity());
  result.max_error = std::sqrt(normal.max_squared_error);
  const Rigid3& last = sightings.back().world_from_camera;
  const Eigen::Vector3d axis = last.rotation * Eigen::Vector3d::UnitZ();
  const double depth = axis.dot(result.point - last.translation);
  result.relative_depth_sigma = std::sqrt(axis.dot(result.covariance * axis)) / depth;
  result.valid = true;
  return result;
}

}  // namespace eifmap
