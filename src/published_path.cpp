#include "published_path.h"

#include <algorithm>

namespace eifmap {

void PublishedPath::add(const FrameResult& result) {
  if (result.rejected) return;
  note_scale(result.map_id, result.scale);
  if (result.state == TrackingState::kTracking)
    published_.push_back(
        {{result.time_us, result.map_from_camera}, result.map_id, result.scale.status});
}

void PublishedPath::note_scale(std::int64_t map_id, const ScaleState& scale) {
  if (scale.status == ScaleStatus::kFixed) metres_per_unit_[map_id] = scale.metres_per_unit;
}

// 1 where it is in metres already, or nobody knows.
double PublishedPath::to_metres(const Published& published) const {
  const auto known = metres_per_unit_.find(published.map_id);
  const bool is_metric = published.scale == ScaleStatus::kFixed;
  return is_metric || known == metres_per_unit_.end() ? 1 : known->second;
}

bool PublishedPath::has_become_metric() const {
  return std::any_of(published_.begin(), published_.end(),
                     [this](const Published& p) { return to_metres(p) != 1; });
}

std::vector<TimedPose> PublishedPath::poses() const {
  std::vector<TimedPose> poses;
  for (const Published& p : published_) {
    poses.push_back(p.pose);
    poses.back().world_from_camera.translation *= to_metres(p);
  }
  return poses;
}

}  // namespace eifmap
