// The books of a map: which measurement was used for what. [WD10] III-A: a raw measurement is used
// once.
#pragma once

#include <string>
#include <vector>

#include "map/map.h"

namespace eifmap {

// What is wrong, one sentence each; empty when the books are right: a measurement (keyframe,
// keypoint) is in at most one relative-pose edge, in none if a track has it, in one track at most;
// the filter holds exactly the sights of the landmarks' tracks, and the index of places the
// keyframes in use.
std::vector<std::string> audit(const Map& map);

}  // namespace eifmap
