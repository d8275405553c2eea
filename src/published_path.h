// Poses as they were published, in metres where a map's scale is known in the end.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "map_view.h"

namespace eifmap {

class PublishedPath {
 public:
  // Frame by frame; only those that track have a pose.
  void add(const FrameResult& result);
  // Of a map, as something else than a pose said it.
  void note_scale(std::int64_t map_id, const ScaleState& scale);

  std::size_t size() const { return published_.size(); }
  std::int64_t last_map_id() const { return published_.empty() ? 0 : published_.back().map_id; }
  // Whether poses() are others than those published.
  bool has_become_metric() const;
  std::vector<TimedPose> poses() const;

 private:
  struct Published {
    TimedPose pose;  // in the unit that the map had then
    std::int64_t map_id = 0;
    ScaleStatus scale = ScaleStatus::kFree;
  };
  double to_metres(const Published& published) const;

  std::vector<Published> published_;
  std::map<std::int64_t, double> metres_per_unit_;  // of the maps whose scale became known
};

}  // namespace eifmap
