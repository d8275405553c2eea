#include "motion/relative_pose.h"

#include <algorithm>
#include <stdexcept>

#include "motion/essential.h"
#include "motion/homography.h"

namespace eifmap {
namespace {

// A homography that explains this share of the pose's inliers explains them as well as the pose.
constexpr double kPlanarRatio = 0.9;

int count(const std::vector<std::uint8_t>& flags) {
  return static_cast<int>(std::count(flags.begin(), flags.end(), 1));
}

int both(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  int number = 0;
  for (std::size_t k = 0; k < a.size(); ++k) number += a[k] && b[k];
  return number;
}

void check_input(std::span<const Correspondence> matches, double radians_per_pixel,
                 const RelativePoseOptions& options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  if (!(radians_per_pixel > 0)) throw std::invalid_argument("radians_per_pixel must be above 0");
  for (const Correspondence& m : matches)
    if (!(m.sigma_i > 0 && m.sigma_j > 0) || !m.x_i.allFinite() || !m.x_j.allFinite())
      throw std::invalid_argument("a correspondence is not finite or has no sigma");
}

bool same_motion(const RelativePose& a, const RelativePose& b) {
  constexpr double kSame = 0.01;  // rad: what the refinement leaves of different starts
  return a.i_from_j.angularDistance(b.i_from_j) < kSame &&
         (a.direction - b.direction).norm() < kSame;
}

void consider_plane(std::span<const Correspondence> matches, const RelativePoseOptions& options,
                    RelativePoseResult& result) {
  const Homography homography = fit_homography(matches, result.inlier);
  result.planar = homography.inlier_ratio > kPlanarRatio;
  if (!result.planar) return;
  for (const RelativePose& start : decompose_homography(homography, matches)) {
    RelativePoseAlternative other{start, {}, 0};
    if (!refine_relative_pose(matches, other.pose, other.inlier, options.covariance)) continue;
    other.num_inliers = count(other.inlier);
    bool known = same_motion(other.pose, result.pose);
    for (const RelativePoseAlternative& a : result.alternatives)
      known = known || same_motion(other.pose, a.pose);
    if (!known) result.alternatives.push_back(std::move(other));
  }
}

}  // namespace

std::string RelativePoseOptions::problem() const {
  if (min_matches < 8) return "relative_pose.min_matches must be at least 8";
  if (!(min_median_parallax_px >= 0)) return "relative_pose.min_median_parallax_px must be >= 0";
  if (!(max_rotation_inlier_ratio > 0 && max_rotation_inlier_ratio <= 1))
    return "relative_pose.max_rotation_inlier_ratio must be in (0, 1]";
  if (!(ransac_threshold_px > 0)) return "relative_pose.ransac_threshold_px must be above 0";
  if (!(ransac_confidence > 0 && ransac_confidence < 1))
    return "relative_pose.ransac_confidence must be in (0, 1)";
  if (ransac_iterations < 1) return "relative_pose.ransac_iterations must be at least 1";
  if (seed < 0) return "relative_pose.seed must be >= 0";
  if (!(min_inlier_ratio >= 0 && min_inlier_ratio <= 1))
    return "relative_pose.min_inlier_ratio must be in [0, 1]";
  return "";
}

RelativePoseResult estimate_relative_pose(std::span<const Correspondence> matches,
                                          double radians_per_pixel,
                                          const RelativePoseOptions& options) {
  check_input(matches, radians_per_pixel, options);
  RelativePoseResult result;
  result.inlier.assign(matches.size(), 0);
  const auto refuse = [&result](Reason reason) {
    result.reason = reason;
    return result;
  };
  const auto number = static_cast<double>(matches.size());
  if (static_cast<int>(matches.size()) < options.min_matches) return refuse(Reason::kTooFewMatches);

  result.rotation = fit_rotation(matches, radians_per_pixel, options);
  const RotationFit& rotation = result.rotation;
  if (rotation.median_parallax < options.min_median_parallax_px * radians_per_pixel ||
      rotation.num_inliers > options.max_rotation_inlier_ratio * number)
    return refuse(Reason::kNoBaseline);

  const std::optional<RelativePose> start =
      search_relative_pose(matches, rotation.i_from_j, radians_per_pixel, options);
  if (!start) return refuse(Reason::kRelativePoseFailed);
  result.pose = *start;
  result.inlier.assign(matches.size(), 1);
  const bool refined =
      refine_relative_pose(matches, result.pose, result.inlier, options.covariance);
  result.num_inliers = count(result.inlier);
  if (!refined || result.num_inliers < options.min_inlier_ratio * number)
    return refuse(Reason::kRelativePoseFailed);
  // Wrong matches hide a rotation from the first test; those that agree with a pose are mostly
  // right.
  if (both(result.inlier, rotation.inlier) > options.max_rotation_inlier_ratio * result.num_inliers)
    return refuse(Reason::kNoBaseline);
  if (options.check_planar) consider_plane(matches, options, result);
  return result;
}

}  // namespace eifmap
