#include "frame_check.h"

#include <cmath>

namespace eifmap {
namespace {

const char* keypoint_problem(const Keypoint& k, const FeatureFrame& frame) {
  // A feature may lie half a pixel outside the outermost pixels' centres.
  if (!(k.u >= -0.5f && k.u <= static_cast<float>(frame.width) - 0.5f))
    return "u outside the image";
  if (!(k.v >= -0.5f && k.v <= static_cast<float>(frame.height) - 0.5f))
    return "v outside the image";
  if (!(k.sigma_px >= 0.01f && k.sigma_px <= 100)) return "sigma_px not within 0.01 to 100";
  if (!(k.scale > 0 && std::isfinite(k.scale))) return "scale not positive";
  if (!std::isfinite(k.angle)) return "angle not finite";
  if (!std::isfinite(k.response)) return "response not finite";
  if (k.laplacian_sign != -1 && k.laplacian_sign != 1) return "laplacian_sign not -1 or +1";
  return nullptr;
}

}  // namespace

FrameCheck check_frame(const FeatureFrame& frame, const Camera& camera) {
  if (frame.width != camera.width || frame.height != camera.height)
    return {Reason::kBadImageSize, "the frame is " + std::to_string(frame.width) + "x" +
                                       std::to_string(frame.height) + ", the calibration is for " +
                                       std::to_string(camera.width) + "x" +
                                       std::to_string(camera.height)};
  if (frame.descriptors.size() != frame.keypoints.size() * kDescriptorSize)
    return {Reason::kBadFeatures, std::to_string(frame.keypoints.size()) + " features with " +
                                      std::to_string(frame.descriptors.size()) +
                                      " bytes of descriptors, wanted " +
                                      std::to_string(kDescriptorSize) + " each"};
  for (std::size_t k = 0; k < frame.keypoints.size(); ++k)
    if (const char* problem = keypoint_problem(frame.keypoints[k], frame))
      return {Reason::kBadFeatures, "feature " + std::to_string(k) + ": " + problem};
  return {};
}

}  // namespace eifmap
