// What a calibration that is a little off does to the scale along a way. It moves all sights alike,
// so that the map follows it and no residual shows it: the filter's own covariance, of errors that
// are independent, has no share of it. It is considered, not estimated (S. F. Schmidt, Advances in
// Control Systems 3, 1966): how far each part of it would move the mean comes out of the same
// factor.
#pragma once

#include <vector>

#include "filter/information_filter.h"

namespace eifmap {

// Standard deviations of what is not known of the calibration.
struct CalibrationSigmas {
  double focal = 0;   // relative
  double centre = 0;  // of the principal point, normalized image coordinates, each axis
  double radial = 0;  // of k1, by which a ray at r from the axis is seen at r (1 + k1 r^2)
};

// Looks at all sights once. Edges' own calibration is left out.
class CalibrationShare {
 public:
  CalibrationShare(const InformationFilter& filter, const CalibrationSigmas& sigmas);

  // The variance that these add to that of the logarithm of the scale which `poses` show
  // (derived_covariances.h). False where the filter cannot tell.
  bool variance(const std::vector<int>& poses, double& variance) const;

 private:
  const InformationFilter& filter_;
  Eigen::MatrixXd steps_;  // of the poses, by block: one column for each part of the calibration
  bool known_ = false;
};

}  // namespace eifmap
