#include "filter/calibration_share.h"

#include <algorithm>

#include "filter/derived_covariances.h"

namespace eifmap {
namespace {

constexpr int kParts = 4;
using OfSight = Eigen::Matrix<double, 2, kParts>;
using OfLandmark = Eigen::Matrix<double, 3, kParts>;

// By how much one sigma of each part moves a keypoint's normalized coordinates.
OfSight moved_by(const Eigen::Vector2d& x, const CalibrationSigmas& sigmas) {
  // Beyond 45 degrees as there: what is true of r^3 there is not further out.
  constexpr double kWide = 1;
  OfSight by;
  by.col(0) = -sigmas.focal * x;
  by.col(1) = Eigen::Vector2d(-sigmas.centre, 0);
  by.col(2) = Eigen::Vector2d(0, -sigmas.centre);
  by.col(3) = -sigmas.radial * std::min(x.squaredNorm(), kWide) * x;
  return by;
}

// The reduced system's right-hand side for sights moved so.
Eigen::MatrixXd right_sides(const InformationFilter& filter, const CalibrationSigmas& sigmas) {
  const PoseBlocks& blocks = filter.blocks();
  Eigen::MatrixXd sides =
      Eigen::MatrixXd::Zero(blocks.count(filter.num_poses()) * kPoseDof, kParts);
  std::vector<OfSight> moved;
  for (int l = 0; l < filter.num_landmarks(); ++l) {
    const FilterLandmark& landmark = filter.landmark(l);
    moved.clear();
    OfLandmark of_landmark = OfLandmark::Zero();
    for (const PointMeasurement& m : landmark.measurements) {
      moved.push_back(m.scale * moved_by(m.x, sigmas));
      of_landmark.noalias() += m.frozen.to_landmark.transpose() * moved.back();
    }
    const OfLandmark step = landmark.covariance * of_landmark;
    for (std::size_t k = 0; k < landmark.measurements.size(); ++k) {
      const PointMeasurement& m = landmark.measurements[k];
      if (m.pose == 0) continue;
      const OfSight left = moved[k] - m.frozen.to_landmark * step;
      sides.middleRows<kPoseDof>(blocks.of(m.pose) * kPoseDof).noalias() +=
          m.d_pose().transpose() * left;
    }
  }
  return sides;
}

}  // namespace

CalibrationShare::CalibrationShare(const InformationFilter& filter, const CalibrationSigmas& sigmas)
    : filter_(filter) {
  known_ = filter.steps_of(right_sides(filter, sigmas), steps_);
}

bool CalibrationShare::variance(const std::vector<int>& poses, double& variance) const {
  Eigen::Matrix3Xd to_centres;
  if (!known_ || !log_scale_derivative(filter_, poses, to_centres)) return false;
  Eigen::RowVectorXd along = Eigen::RowVectorXd::Zero(kParts);
  for (std::size_t k = 0; k < poses.size(); ++k)
    if (const int p = poses[k]; p != 0)
      along += to_centres.col(static_cast<Eigen::Index>(k)).transpose() *
               steps_.middleRows<3>(filter_.blocks().of(p) * kPoseDof + kPoseDof - 3);
  variance = along.squaredNorm();
  return true;
}

}  // namespace eifmap
