#include "map/observed_frame.h"

namespace eifmap {

ObservedFrame observe(const FeatureFrame& frame, const Camera& camera, int map_sign,
                      double sigma_factor) {
  ObservedFrame observed;
  observed.frame = frame;
  observed.x.reserve(frame.keypoints.size());
  observed.sigma.reserve(frame.keypoints.size());
  for (const Keypoint& keypoint : frame.keypoints) {
    observed.x.push_back(camera.normalized_from_pixel({keypoint.u, keypoint.v}));
    observed.sigma.push_back(sigma_factor * keypoint.sigma_px * camera.radians_per_pixel());
  }
  observed.omega_m = features_of_sign(frame, map_sign);
  observed.omega_p = features_of_sign(frame, -map_sign);
  return observed;
}

}  // namespace eifmap
