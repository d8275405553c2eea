// Whether a frame may reach the map.
#pragma once

#include <string>

#include "frame.h"
#include "geometry/camera.h"
#include "reason.h"

namespace eifmap {

struct FrameCheck {
  Reason reason = Reason::kNone;
  std::string detail;  // which value, and what was wanted
  bool ok() const { return reason == Reason::kNone; }
};

// "" or which value of the keypoint is wrong and what was wanted; width and height of its image in
// px.
std::string keypoint_problem(const Keypoint& keypoint, int width, int height);

// Sizes, finiteness and ranges of everything in the frame. Costs microseconds, and nothing is
// assumed about who made the frame.
FrameCheck check_frame(const FeatureFrame& frame, const Camera& camera);

}  // namespace eifmap
