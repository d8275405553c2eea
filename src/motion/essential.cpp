#include "motion/essential.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <opencv2/calib3d.hpp>

#include "geometry/robust.h"
#include "motion/epipolar_geometry.h"

namespace eifmap {
namespace {

// A threshold that cuts into the noise makes RANSAC take three times as long.
constexpr double kInlierSigma = 2.5;

double usual_sigma(std::span<const Correspondence> matches) {
  std::vector<double> sigmas;
  sigmas.reserve(matches.size());
  for (const Correspondence& m : matches) sigmas.push_back(0.5 * (m.sigma_i + m.sigma_j));
  return take_median(sigmas);
}

// OpenCV's five-point RANSAC with MAGSAC++ scores. One thread and a state of its own: the same
// matches always give the same matrix. Its threshold is converted with the camera matrix, so it
// gets the pixels of a camera of our focal length. Empty when it finds none.
std::optional<Eigen::Matrix3d> find_essential(std::span<const Correspondence> matches,
                                              double radians_per_pixel,
                                              const RelativePoseOptions& options) {
  cv::UsacParams params;
  params.confidence = options.ransac_confidence;
  params.isParallel = false;
  params.loIterations = 1;  // the refinement after it is ours
  params.loMethod = cv::LOCAL_OPTIM_SIGMA;
  params.maxIterations = options.ransac_iterations;
  params.randomGeneratorState = options.seed;
  params.sampler = cv::SAMPLING_UNIFORM;
  params.score = cv::SCORE_METHOD_MAGSAC;
  params.threshold = std::max(options.ransac_threshold_px,
                              kInlierSigma * usual_sigma(matches) / radians_per_pixel);

  const double focal = 1 / radians_per_pixel;
  std::vector<cv::Point2d> pixels_i, pixels_j;
  pixels_i.reserve(matches.size());
  pixels_j.reserve(matches.size());
  for (const Correspondence& m : matches) {
    pixels_i.emplace_back(focal * m.x_i.x(), focal * m.x_i.y());
    pixels_j.emplace_back(focal * m.x_j.x(), focal * m.x_j.y());
  }
  const cv::Matx33d camera(focal, 0, 0, 0, focal, 0, 0, 0, 1);
  cv::Mat found;
  try {
    cv::Mat mask;
    // OpenCV's x2' E x1 = 0 with j first is ours: x_i' [t]x R x_j = 0.
    found = cv::findEssentialMat(pixels_j, pixels_i, camera, camera, cv::noArray(), cv::noArray(),
                                 mask, params);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (found.rows != 3 || found.cols != 3 || found.type() != CV_64F) return std::nullopt;
  Eigen::Matrix3d essential;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) essential(r, c) = found.at<double>(r, c);
  if (!essential.allFinite()) return std::nullopt;
  return essential;
}

// The two rotations and two directions of an essential matrix (Hartley, Zisserman, result 9.19).
std::array<RelativePose, 4> decompose(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
  if (u.determinant() < 0) u.col(2) *= -1;
  if (v.determinant() < 0) v.col(2) *= -1;
  Eigen::Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  std::array<RelativePose, 4> poses;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Matrix3d turned = k < 2 ? w : w.transpose();
    poses[k].i_from_j =
        Eigen::Quaterniond(Eigen::Matrix3d(u * turned * v.transpose())).normalized();
    poses[k].direction = (k % 2 == 0 ? 1 : -1) * u.col(2);
  }
  return poses;
}

// Points in front less points behind, of the matches near their epipolar lines.
int cheirality_votes(std::span<const Correspondence> matches, const RelativePose& pose) {
  constexpr double kNear = 4;  // whitened
  const EpipolarGeometry geometry(pose);
  int votes = 0;
  for (const Correspondence& m : matches) {
    if (std::abs(geometry.residual(m)) > kNear) continue;
    const DepthSign sign = geometry.depth_sign(m);
    votes += (sign == DepthSign::kInFront) - (sign == DepthSign::kBehind);
  }
  return votes;
}

}  // namespace

std::optional<RelativePose> search_relative_pose(std::span<const Correspondence> matches,
                                                 const Eigen::Quaterniond& rotation,
                                                 double radians_per_pixel,
                                                 const RelativePoseOptions& options) {
  const std::optional<Eigen::Matrix3d> essential =
      find_essential(matches, radians_per_pixel, options);
  if (!essential) return std::nullopt;
  std::optional<RelativePose> best;
  int best_votes = 0;
  for (const RelativePose& pose : decompose(*essential)) {
    const int votes = cheirality_votes(matches, pose);
    const bool nearer =
        best && pose.i_from_j.angularDistance(rotation) < best->i_from_j.angularDistance(rotation);
    if (!best || votes > best_votes || (votes == best_votes && nearer)) {
      best = pose;
      best_votes = votes;
    }
  }
  return best;
}

}  // namespace eifmap
