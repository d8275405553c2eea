// What is in a KeyframeJob.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "map/calibration_check.h"
#include "map/keyframe_insertion.h"
#include "map/loop_closing.h"
#include "map/map.h"
#include "map/map_merge.h"
#include "map/map_news.h"
#include "map/measurement_desk.h"
#include "map/tracking.h"
#include "map_view.h"
#include "options.h"

namespace eifmap {

struct KeyframeWork {
  std::int64_t id = 0, map_id = 0;
  std::int64_t stay = 0;  // counts how often the camera came into a map: of this one
  MapperOptions options;
  std::shared_ptr<const ObservedFrame> observed;
  Tracking tracking;             // of the frame in `before`
  std::vector<int> hardly_seen;  // landmarks (tracks), see SightCounts
  MeasurementDesk::Taken measurements;
  std::shared_ptr<const Map> before;  // read by the tracking meanwhile
  std::optional<MapNews> news;        // of `before`; none: nobody wants updates of the map
  std::optional<CalibrationCheck> calibration;  // its pairs so far; run() adds to them
  LoopSearch loop_search;                       // what it knows so far, as well
  // Other maps that it may turn out to be in.
  std::vector<KeptView> kept;
  MergeSearch merge_search;      // what it knows so far
  std::optional<SafeView> view;  // with kept maps

  // Made by run().
  std::shared_ptr<Map> after;
  Insertion insertion;  // with a reason: `after` is not to be trusted, and `before` goes on
  LoopOutcome loop;     // of `after`, which it is in where it was closed
  MergeOutcome merge;   // of `after`, which it is not in
  std::optional<MapUpdate> update;
};

}  // namespace eifmap
