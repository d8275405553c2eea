#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "geometry/projection.h"
#include "motion/absolute_pose.h"
#include "motion/sampler.h"

namespace eifmap {
namespace {

// The poses (up to four) from which three points are seen where they were.
std::vector<Rigid3> poses_of_three(std::span<const MapObservation> observations,
                                   const std::array<std::size_t, 3>& sample) {
  std::array<cv::Point3d, 3> points;
  std::array<cv::Point2d, 3> images;
  for (int k = 0; k < 3; ++k) {
    const MapObservation& o = observations[sample[k]];
    points[k] = {o.point.x(), o.point.y(), o.point.z()};
    images[k] = {o.x.x(), o.x.y()};
  }
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solveP3P(points, images, cv::Matx33d::eye(), cv::noArray(), rotations, translations,
                 cv::SOLVEPNP_AP3P);
  } catch (const cv::Exception&) {
    return {};
  }
  std::vector<Rigid3> poses;
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    const cv::Vec3d w = rotations[k], t = translations[k];
    const Rigid3 camera_from_world(so3_exp({w[0], w[1], w[2]}), {t[0], t[1], t[2]});
    if (camera_from_world.translation.allFinite() && w == w)
      poses.push_back(camera_from_world.inverse());
  }
  return poses;
}

// Truncated squared errors: what RANSAC minimizes.
double cost_of(const Rigid3& pose, std::span<const MapObservation> observations, double threshold,
               double best_cost, int& num_inliers) {
  const Projector camera(pose);
  double cost = 0;
  num_inliers = 0;
  Eigen::Vector2d x;
  for (const MapObservation& o : observations) {
    const double squared =
        camera(o.point, x) ? (o.x - x).squaredNorm() / (threshold * threshold) : 1;
    cost += std::min(1.0, squared);
    num_inliers += squared < 1;
    if (cost >= best_cost) return cost;
  }
  return cost;
}

}  // namespace

AbsolutePose solve_pnp(std::span<const MapObservation> observations, double radians_per_pixel,
                       const AbsolutePoseOptions& options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  if (!(radians_per_pixel > 0)) throw std::invalid_argument("radians_per_pixel must be above 0");
  AbsolutePose failed;
  failed.inlier.assign(observations.size(), 0);
  if (static_cast<int>(observations.size()) < options.min_inliers) return failed;

  Sampler sampler(options.seed);
  const double threshold = options.ransac_threshold_px * radians_per_pixel;
  double best_cost = std::numeric_limits<double>::infinity();
  Rigid3 best;
  int needed = options.ransac_iterations, num_inliers = 0;
  for (int iteration = 0; iteration < needed; ++iteration) {
    const auto sample = sampler.draw<3>(observations.size());
    for (const Rigid3& pose : poses_of_three(observations, sample)) {
      const double cost = cost_of(pose, observations, threshold, best_cost, num_inliers);
      if (!(cost < best_cost)) continue;
      best_cost = cost;
      best = pose;
      const double ratio =
          static_cast<double>(num_inliers) / static_cast<double>(observations.size());
      needed = ransac_iterations_needed(ratio, 3, options.ransac_confidence, needed);
    }
  }
  if (!(best_cost < static_cast<double>(observations.size()))) return failed;
  return refine_absolute_pose(best, observations, options);
}

}  // namespace eifmap
