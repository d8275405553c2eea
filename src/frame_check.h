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

// Sizes, finiteness and ranges of everything in the frame. Costs microseconds, and nothing is
// assumed about who made the frame.
FrameCheck check_frame(const FeatureFrame& frame, const Camera& camera);

}  // namespace eifmap
