// Where the newest keyframe may have been before: places that look like it, and that are not what
// it has just come from.
#pragma once

#include <optional>
#include <vector>

#include "map/map.h"
#include "options.h"

namespace eifmap {

// By keyframe: 1 where a loop with `newest` may be closed: in use, older than the latest few, and
// seeing nothing that `newest` or a keyframe around it sees.
std::vector<char> may_close(const Map& map, int newest, const LoopOptions& options);

// Of those, the keyframes that look most like the frame (the index of places), best first; none
// before the index is ready. At most `count`.
std::vector<int> places_by_look(const Map& map, const FeatureFrame& frame,
                                const std::vector<char>& allowed, int count);

// Of those, the keyframes that may show what `newest` shows by where they are: such as look the
// same way and are as near as the map may be off, and one of all others. So few of them that they
// take several keyframes to be gone through: `turn` counts those.
std::vector<int> places_by_position(const Map& map, int newest, const std::vector<char>& allowed,
                                    int turn, int count);

// Half by their looks, half by where they are: neither misses what the other one does.
std::vector<int> likely_places(const Map& map, int newest, int turn, const LoopOptions& options);

// Remembers what the keyframes before have found: a place must be seen again by several in a row.
class LoopSearch {
 public:
  // Matches `newest` with at most options.max_candidates keyframes: those around the place that the
  // keyframe before has found, then `places`, likeliest first. The keyframe that shares most with
  // it, once enough in a row have found places around it.
  std::optional<int> look(const Map& map, int newest, const std::vector<int>& places,
                          const MapperOptions& options);
  void begin_anew() { found_.reset(), support_ = 0; }
  int turn() const { return turn_; }

 private:
  std::optional<int> found_;  // by the keyframe before
  int support_ = 0;           // keyframes in a row
  int turn_ = 0;
};

}  // namespace eifmap
