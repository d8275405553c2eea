// What a mapper would go on with after a restart: a copy costs what becomes another in it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "map/map.h"
#include "map/trajectory_log.h"

namespace eifmap {

struct MapSnapshot {
  std::int64_t map_id = 0;
  std::int64_t epoch = 0;  // FrameResult::map_epoch, when it was in use last
  std::shared_ptr<const Map> map;
  TrajectoryLog log;
  std::vector<int> most_tracked;  // LiveMap's
  int removed_keyframes = 0, removed_landmarks = 0, reference = 0;
};

struct MapperSnapshot {
  std::optional<MapSnapshot> in_use;
  std::vector<MapSnapshot> kept;
  std::int64_t last_map_id = 0;  // of the map that was started last
  std::int64_t next_epoch = 0;   // of the map that is started first, with none in use
};

}  // namespace eifmap
