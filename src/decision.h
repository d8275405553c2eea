// What a live run decides by timing: which frames are taken, and before which of them a keyframe's
// job is adopted (keyframe_job.h), an absolute measurement is taken, and the map is given up by
// command. With these a replay makes the same map.
#pragma once

#include <cstdint>
#include <vector>

#include "map_view.h"

namespace eifmap {

struct Decision {
  std::int64_t time_us = 0, publisher = 0, seq = -1;  // the frame's
  std::int64_t adopted_job = 0;                       // as FrameResult's
  std::int64_t state_digest = 0;  // of the frame's result: where a replay's is another, it departed
  std::vector<MeasurementId> measurements = {};  // as FrameResult's
  bool after_reset = false;                      // as FrameResult's
  bool operator==(const Decision&) const = default;
};

Decision decision_of(const FrameResult& result);

}  // namespace eifmap
