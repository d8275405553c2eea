#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/rigid3.h"
#include "geometry/robust.h"
#include "motion/relative_pose.h"
#include "motion/sampler.h"

namespace eifmap {
namespace {

// 95 % of matches that noise alone moves are within this many standard deviations (two dimensions).
constexpr double kInlierSigma = 2.4477;

// A match as two unit vectors.
struct Bearings {
  Eigen::Vector3d f_i, f_j;
  double limit;  // rad, residual of an inlier
};

std::vector<Bearings> bearings_of(std::span<const Correspondence> matches, double floor) {
  std::vector<Bearings> bearings;
  bearings.reserve(matches.size());
  for (const Correspondence& m : matches) {
    const double limit = std::max(floor, kInlierSigma * std::hypot(m.sigma_i, m.sigma_j));
    const Eigen::Vector3d f_i = m.x_i.homogeneous().normalized();
    // Off the axis a step in the image is a smaller angle.
    bearings.push_back({f_i, m.x_j.homogeneous().normalized(), limit * f_i.z()});
  }
  return bearings;
}

// The frame that two directions span: the first, and two at right angles to it.
Eigen::Matrix3d frame_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  Eigen::Matrix3d frame;
  frame.col(0) = a;
  frame.col(2) = a.cross(b).normalized();
  frame.col(1) = frame.col(2).cross(a);
  return frame;
}

// Truncated squared residuals: what RANSAC minimizes.
double cost_of(const Eigen::Matrix3d& i_from_j, const std::vector<Bearings>& bearings,
               double best_cost, int& num_inliers) {
  double cost = 0;
  num_inliers = 0;
  for (const Bearings& b : bearings) {
    const double squared = (b.f_i - i_from_j * b.f_j).squaredNorm() / (b.limit * b.limit);
    cost += std::min(1.0, squared);
    num_inliers += squared < 1;
    if (cost >= best_cost) return cost;
  }
  return cost;
}

Eigen::Quaterniond search_rotation(const std::vector<Bearings>& bearings,
                                   const RelativePoseOptions& options) {
  Sampler sampler(options.seed);
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  int num_inliers = 0;
  double best_cost = cost_of(best, bearings, 1e300, num_inliers);
  int needed = std::min(options.ransac_iterations, 200);
  for (int iteration = 0; iteration < needed; ++iteration) {
    const auto [a, b] = sampler.draw<2>(bearings.size());
    // Two directions close together fix no rotation.
    if (bearings[a].f_j.cross(bearings[b].f_j).squaredNorm() < 1e-4) continue;
    const Eigen::Matrix3d i_from_j = frame_of(bearings[a].f_i, bearings[b].f_i) *
                                     frame_of(bearings[a].f_j, bearings[b].f_j).transpose();
    const double cost = cost_of(i_from_j, bearings, best_cost, num_inliers);
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best = i_from_j;
    const double ratio = static_cast<double>(num_inliers) / static_cast<double>(bearings.size());
    needed =
        std::min(needed, ransac_iterations_needed(ratio, 2, options.ransac_confidence, needed));
  }
  return Eigen::Quaterniond(best).normalized();
}

// Gauss-Newton with bisquare weights on f_i - R f_j. The limit stays above every inlier's, so that
// matches with real parallax pull little.
Eigen::Quaterniond refine_rotation(Eigen::Quaterniond i_from_j,
                                   const std::vector<Bearings>& bearings) {
  for (int iteration = 0; iteration < 10; ++iteration) {
    const Eigen::Matrix3d r = i_from_j.toRotationMatrix();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const Bearings& b : bearings) {
      const Eigen::Vector3d f_i_in_j = r.transpose() * b.f_i;
      const Eigen::Vector3d error = f_i_in_j - b.f_j;
      const double weight = bisquare_weight(error.norm(), 2 * b.limit) / (b.limit * b.limit);
      if (weight == 0) continue;
      // error(w) ~ error - w x f_j: J'J = I - f_j f_j', J' error = f_j x error.
      information += weight * (Eigen::Matrix3d::Identity() - b.f_j * b.f_j.transpose());
      gradient += weight * b.f_j.cross(error);
    }
    const Eigen::LLT<Eigen::Matrix3d> factor(information);
    if (factor.info() != Eigen::Success) break;
    const Eigen::Vector3d w = factor.solve(gradient);
    if (!w.allFinite()) break;
    i_from_j = (i_from_j * so3_exp(w)).normalized();
    if (w.norm() < 1e-9) break;
  }
  return i_from_j;
}

}  // namespace

RotationFit fit_rotation(std::span<const Correspondence> matches, double radians_per_pixel,
                         const RelativePoseOptions& options) {
  RotationFit fit;
  fit.inlier.assign(matches.size(), 0);
  if (matches.size() < 2) return fit;
  const std::vector<Bearings> bearings =
      bearings_of(matches, options.ransac_threshold_px * radians_per_pixel);
  fit.i_from_j = refine_rotation(search_rotation(bearings, options), bearings);

  const Eigen::Matrix3d r = fit.i_from_j.toRotationMatrix();
  std::vector<double> parallax(bearings.size());
  for (std::size_t k = 0; k < bearings.size(); ++k) {
    const Eigen::Vector3d turned = r * bearings[k].f_j;
    parallax[k] = std::atan2(bearings[k].f_i.cross(turned).norm(), bearings[k].f_i.dot(turned));
    fit.inlier[k] = parallax[k] < bearings[k].limit;
    fit.num_inliers += fit.inlier[k];
  }
  fit.median_parallax = take_median(parallax);
  return fit;
}

}  // namespace eifmap
