// A place that is seen again closes a loop: the map is bent so that both passes of it agree, what
// they share is joined, and the filter's own update says where everything is.
#pragma once

#include <string>
#include <vector>

#include "map/loop_search.h"
#include "map/map.h"
#include "options.h"

namespace eifmap {

struct LoopOutcome {
  bool found = false;             // a place that the newest keyframe seems to have seen before
  Reason reason = Reason::kNone;  // and was closed; or why it was not, and the map is as it was
  std::string detail;             // with its numbers
  int old = 0, newest = 0;        // keyframes
  int joined = 0;                 // tracks
  // Of a map that was bent, by keyframe: how much what is near it has grown. Empty: both passes
  // agreed already as far as images tell, and were joined as they were.
  std::vector<double> growth;

  bool closed() const { return found && reason == Reason::kNone; }
};

// After a keyframe's update.
LoopOutcome close_loop(Map& map, int newest, LoopSearch& search, const MapperOptions& options);

}  // namespace eifmap
