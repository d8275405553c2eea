// A frame prepared for mapping: undistorted, and its features split by Laplacian sign.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "features/matcher.h"
#include "frame.h"
#include "geometry/camera.h"
#include "motion/relative_pose.h"

namespace eifmap {

// The Laplacian sign whose features make the map; the other one's give relative poses.
enum class MapSign { kMinus, kPlus, kBoth };

struct ObservedFrame {
  FeatureFrame frame;              // without the keypoints beyond kMaxViewAngle
  std::vector<Eigen::Vector2d> x;  // per keypoint: normalized image coordinates
  std::vector<double> sigma;       // per keypoint: of x, each axis
  double sigma_factor = 1;         // that is in it
  FeatureGroup minus, plus;        // [WD10] II: by Laplacian sign; the two are never matched
  MapSign map_sign = MapSign::kMinus;

  int size() const { return static_cast<int>(x.size()); }
  int sign(int keypoint) const { return frame.keypoints[keypoint].laplacian_sign; }
  // [WD10] II: Omega_m is for the map, Omega_p for relative poses.
  bool in_omega_m(int keypoint) const {
    return map_sign == MapSign::kBoth || (sign(keypoint) < 0) == (map_sign == MapSign::kMinus);
  }
  const std::int8_t* descriptor(int keypoint) const {
    return frame.descriptors.data() + static_cast<std::ptrdiff_t>(keypoint) * kDescriptorSize;
  }
};

// `sigma_factor`: what the keypoints' sigmas are multiplied by (MapperOptions, SightNoise).
ObservedFrame observe(const FeatureFrame& frame, const Camera& camera, MapSign map_sign,
                      double sigma_factor);

// What a match of two frames says of their relative pose.
inline Correspondence correspondence(const ObservedFrame& i, const ObservedFrame& j,
                                     const Match& match) {
  return {i.x[match.a], j.x[match.b], i.sigma[match.a], j.sigma[match.b]};
}

// a: keypoint of i, b: of j; sorted by a within a sign. The two frames have the same map_sign.
std::vector<Match> match_omega_m(const ObservedFrame& i, const ObservedFrame& j,
                                 const MatchOptions& options);
std::vector<Match> match_omega_p(const ObservedFrame& i, const ObservedFrame& j,
                                 const MatchOptions& options);

}  // namespace eifmap
