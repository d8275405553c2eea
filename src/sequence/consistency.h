// Whether errors are as large as their covariances say: the truth brought into the gauge of a map,
// and the normalized estimation error squared (NEES) of a pose (Y. Bar-Shalom et al., Estimation
// with Applications to Tracking and Navigation, 5.4).
#pragma once

#include <Eigen/Core>

#include "geometry/rigid3.h"

namespace eifmap {

using PoseVector = Eigen::Matrix<double, 6, 1>;
using PoseMatrix = Eigen::Matrix<double, 6, 6>;

// The gauge of a map: keyframe 0 is where it is by definition, and the first baseline, from
// keyframe 0 to keyframe 1, keeps its length along its first direction.
class TruthInMap {
 public:
  // `world_from_first`, `world_from_second`: true poses of keyframes 0 and 1, in the truth's frame
  // and unit. `second_centre`: keyframe 1's centre as first published, map; the published one has
  // gone through one update, which moves it across the direction that is held by a part so small
  // that its square, which is what counts here, is below 1e-4.
  TruthInMap(const Rigid3& world_from_first, const Rigid3& world_from_second,
             const Eigen::Vector3d& second_centre);

  Rigid3 operator()(const Rigid3& world_from_camera) const;  // map_from_camera
  // The same of a map that is in the truth's unit.
  Rigid3 in_metres(const Rigid3& world_from_camera) const {
    return first_from_world_ * world_from_camera;
  }
  double scale() const { return scale_; }  // map units per unit of the truth

 private:
  Rigid3 first_from_world_;
  double scale_ = 1;
};

// (displacement of the centre in the map, rotation vector in the camera's frame), the wire's order:
// what must be added to the estimate to get the truth.
PoseVector pose_error(const Rigid3& estimate, const Rigid3& truth);

// error' covariance^-1 error, 6 on average where the covariance is right; infinite where it is not
// positive definite.
double nees(const PoseVector& error, const PoseMatrix& covariance);

}  // namespace eifmap
