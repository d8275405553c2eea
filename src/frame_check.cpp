#include "frame_check.h"

#include <cmath>

namespace eifmap {
namespace {

// Coordinates are of pixel centres, so the image reaches half a pixel further.
bool inside(float x, int side) {
  return x >= -0.5f && x <= static_cast<float>(side) - 0.5f;
}

}  // namespace

std::string keypoint_problem(const Keypoint& k, int width, int height) {
  if (!inside(k.u, width) || !inside(k.v, height))
    return "at (" + std::to_string(k.u) + ", " + std::to_string(k.v) + "), outside the image";
  if (!(k.sigma_px >= 0.01f && k.sigma_px <= 100))
    return "sigma_px is " + std::to_string(k.sigma_px) + ", wanted 0.01 to 100";
  if (!(k.scale > 0 && std::isfinite(k.scale)))
    return "scale is " + std::to_string(k.scale) + ", wanted above 0";
  if (!std::isfinite(k.angle)) return "angle is not finite";
  if (!std::isfinite(k.response)) return "response is not finite";
  if (k.laplacian_sign != 1 && k.laplacian_sign != -1)
    return "laplacian_sign is " + std::to_string(k.laplacian_sign) + ", wanted -1 or 1";
  return "";
}

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
    if (const std::string problem = keypoint_problem(frame.keypoints[k], frame.width, frame.height);
        !problem.empty())
      return {Reason::kBadFeatures, "feature " + std::to_string(k) + ": " + problem};
  return {};
}

}  // namespace eifmap
