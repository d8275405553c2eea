// Two maps that turn out to be of one place become one.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "map/merge_search.h"

namespace eifmap {

struct MergeOutcome {
  bool found = false;             // a kept map that seems to show what the newest keyframe shows
  Reason reason = Reason::kNone;  // and became one with the map; or why not, and both are as before
  std::string detail;             // with its numbers
  std::int64_t map_id = 0;        // the kept map's
  int joined = 0;                 // tracks
  std::shared_ptr<Map> merged;    // null: they were not merged
  // The map with the lower id stays as it is numbered, and its gauge; the other is appended.
  bool into_kept = false;
  Appended appended;
};

// After a keyframe's update. `map_id`: of `here`. `kept`: other maps; nothing of them is changed.
MergeOutcome merge_maps(const Map& here, std::int64_t map_id, int newest,
                        const std::vector<KeptView>& kept, const SafeView& view,
                        MergeSearch& search, const MapperOptions& options);

}  // namespace eifmap
