#include "motion/epipolar.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <opencv2/calib3d.hpp>

namespace eifmap {
namespace {

// OpenCV's five-point RANSAC with MAGSAC++ scores. One thread and a state of its own: the same
// matches always give the same matrix. Its threshold is converted with the camera matrix, so it
// gets the pixels of a camera of our focal length. Empty when it finds none.
std::optional<Eigen::Matrix3d> find_essential(std::span<const Correspondence> matches,
                                              double radians_per_pixel,
                                              const RelativePoseOptions& options) {
  cv::UsacParams params;
  params.confidence = options.ransac_confidence;
  params.isParallel = false;
  params.loIterations = 5;
  params.loMethod = cv::LOCAL_OPTIM_SIGMA;
  params.loSampleSize = 14;
  params.maxIterations = options.ransac_iterations;
  params.randomGeneratorState = options.seed;
  params.sampler = cv::SAMPLING_UNIFORM;
  params.score = cv::SCORE_METHOD_MAGSAC;
  params.threshold = options.ransac_threshold_px;

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
  const Eigen::Matrix3d r = pose.i_from_j.toRotationMatrix();
  int votes = 0;
  for (const Correspondence& m : matches) {
    if (std::abs(sampson_residual(m, pose)) > kNear) continue;
    const DepthSign sign = depth_sign(m, r, pose.direction);
    votes += (sign == DepthSign::kInFront) - (sign == DepthSign::kBehind);
  }
  return votes;
}

}  // namespace

DepthSign depth_sign(const Correspondence& match, const Eigen::Matrix3d& i_from_j,
                     const Eigen::Vector3d& direction) {
  // depth_i x_i = depth_j y + t with y = R x_j; crossed with y, and with x_i.
  const Eigen::Vector3d x = match.x_i.homogeneous(), y = i_from_j * match.x_j.homogeneous();
  const Eigen::Vector3d normal = x.cross(y);
  const double noise = 3 * std::hypot(match.sigma_i, match.sigma_j);
  if (normal.squaredNorm() < noise * noise * x.squaredNorm() * y.squaredNorm())
    return DepthSign::kUndecided;
  const bool in_front = direction.cross(y).dot(normal) > 0 && direction.cross(x).dot(normal) > 0;
  return in_front ? DepthSign::kInFront : DepthSign::kBehind;
}

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
