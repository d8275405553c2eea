// A frame prepared for mapping: undistorted, and its features split by Laplacian sign.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "features/matcher.h"
#include "frame.h"
#include "geometry/camera.h"

namespace eifmap {

struct ObservedFrame {
  FeatureFrame frame;              // without the keypoints beyond kMaxViewAngle
  std::vector<Eigen::Vector2d> x;  // per keypoint: normalized image coordinates
  std::vector<double> sigma;       // per keypoint: of x, each axis
  FeatureGroup omega_m, omega_p;   // [WD10] II: for the map, for relative poses

  int size() const { return static_cast<int>(x.size()); }
  const std::int8_t* descriptor(int keypoint) const {
    return frame.descriptors.data() + static_cast<std::ptrdiff_t>(keypoint) * kDescriptorSize;
  }
};

// `map_sign`: the Laplacian sign of Omega_m. `sigma_factor`: MapperOptions.
ObservedFrame observe(const FeatureFrame& frame, const Camera& camera, int map_sign,
                      double sigma_factor);

}  // namespace eifmap
