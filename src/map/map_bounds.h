// Keeps a map within its bounds. The least informative goes first, with its measurements: what is
// left is what a map without them would be, and nothing is put in their place that would count as
// knowledge (no priors of what was marginalized out).
#pragma once

#include <vector>

#include "map/map.h"
#include "options.h"

namespace eifmap {

// How a map hangs together. Keyframes are linked that share enough landmarks of three sights and
// more: of two, a landmark says nothing of how long one baseline is next to another. One keyframe
// alone between two parts (a cut) hands on no scale from the one to the other.
struct MapStructure {
  int parts = 0, cuts = 0;
  bool operator==(const MapStructure&) const = default;
};
// `without`: of the map without that keyframe; -1: of all of it.
MapStructure map_structure(const Map& map, int without = -1);

// More landmarks than options.max_landmarks.
bool is_crowded(const Map& map, const BoundOptions& options);

// Before a keyframe comes into a map that has options.max_keyframes: takes out a hundredth of them,
// and one of a map that is still crowded, so that its landmarks may go;
// those first of whose landmarks the most are seen by three others and more. Never the first two,
// the newest or one around `reference`; nor one without which the map has more parts or cuts.
// Returns how many; none, where none can go: the map is full.
int make_room(Map& map, int reference, const BoundOptions& options);

// The same of landmarks beyond options.max_landmarks: those first that have the fewest sights, of
// them those not seen for longest. Those in view of `newest` go last, and none that would leave a
// keyframe with too few or unlink two: then keyframes must go first. Returns how many.
int drop_landmarks(Map& map, int newest, const BoundOptions& options);

}  // namespace eifmap
