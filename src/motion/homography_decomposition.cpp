#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "motion/homography.h"

namespace eifmap {
namespace {

// A translation below this share of the plane's distance is rounding, not motion.
constexpr double kMinTranslation = 1e-6;
// A plane does not pass between its points, but noise turns some of those at its horizon. Of the
// points in front less those behind, the share that must be left.
constexpr double kMinInFront = 0.6;

// The homography with the scale and sign that R + T n' has: middle singular value 1, and the points
// stay in front of the camera.
Eigen::Matrix3d scaled(const Homography& homography, std::span<const Correspondence> matches,
                       double middle_singular_value) {
  const Eigen::Matrix3d h = homography.i_from_j / middle_singular_value;
  int votes = 0;
  for (std::size_t k = 0; k < matches.size(); ++k)
    if (homography.inlier[k])
      votes += matches[k].x_i.homogeneous().dot(h * matches[k].x_j.homogeneous()) > 0 ? 1 : -1;
  return votes < 0 ? Eigen::Matrix3d(-h) : h;
}

// Points of the plane that `normal` puts in front of j, less those behind.
int in_front(const Eigen::Vector3d& normal, const Homography& homography,
             std::span<const Correspondence> matches) {
  int votes = 0;
  for (std::size_t k = 0; k < matches.size(); ++k)
    if (homography.inlier[k]) votes += normal.dot(matches[k].x_j.homogeneous()) > 0 ? 1 : -1;
  return votes;
}

// Columns: a, b, a x b.
Eigen::Matrix3d frame_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  Eigen::Matrix3d frame;
  frame << a, b, a.cross(b);
  return frame;
}

}  // namespace

// H = R + T n' keeps the lengths of all vectors at right angles to n. Those lengths are known from
// H'H, whose eigenvalues are a >= 1 >= c: the vectors kept lie in two planes that meet in the
// middle eigenvector. Each plane with its image gives a rotation, its normal n, and T (Y. Ma, S.
// Soatto, J. Kosecka, S. Sastry: An Invitation to 3-D Vision, 5.3.3).
std::vector<RelativePose> decompose_homography(const Homography& homography,
                                               std::span<const Correspondence> matches) {
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>;
  const Solver unscaled(homography.i_from_j.transpose() * homography.i_from_j,
                        Eigen::EigenvaluesOnly);
  const double middle = std::sqrt(unscaled.eigenvalues()[1]);
  if (!(middle > 1e-12 * homography.i_from_j.norm())) return {};
  const Eigen::Matrix3d h = scaled(homography, matches, middle);
  const Solver solver(h.transpose() * h);
  const double stretched = std::max(0.0, solver.eigenvalues()[2] - 1);  // a - 1
  const double shrunk = std::max(0.0, 1 - solver.eigenvalues()[0]);     // 1 - c
  if (!(std::sqrt(stretched + shrunk) > kMinTranslation)) return {};
  const Eigen::Vector3d kept = solver.eigenvectors().col(1);

  struct Candidate {
    RelativePose pose;
    int votes;
  };
  std::vector<Candidate> candidates;
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d also_kept = (std::sqrt(shrunk) * solver.eigenvectors().col(2) +
                                       side * std::sqrt(stretched) * solver.eigenvectors().col(0)) /
                                      std::sqrt(stretched + shrunk);
    const Eigen::Matrix3d rotation =
        frame_of(h * kept, h * also_kept) * frame_of(kept, also_kept).transpose();
    Eigen::Vector3d normal = kept.cross(also_kept);
    int votes = in_front(normal, homography, matches);
    if (votes < 0) normal = -normal, votes = -votes;
    const Eigen::Vector3d translation = (h - rotation) * normal;
    if (!(translation.norm() > kMinTranslation)) continue;
    candidates.push_back({{}, votes});
    candidates.back().pose.i_from_j = Eigen::Quaterniond(rotation).normalized();
    candidates.back().pose.direction = translation.normalized();
  }
  if (candidates.size() == 2 && candidates[1].votes > candidates[0].votes)
    std::swap(candidates[0], candidates[1]);
  const auto inliers = static_cast<double>(
      std::count(homography.inlier.begin(), homography.inlier.end(), std::uint8_t{1}));
  std::vector<RelativePose> poses;
  for (const Candidate& candidate : candidates)
    if (candidate.votes > kMinInFront * inliers) poses.push_back(candidate.pose);
  return poses;
}

}  // namespace eifmap
