// Keyframes that hardly say anything which others do not say: where the camera has been before, the
// map must not grow without end.
#pragma once

#include <optional>

#include "map/map.h"
#include "options.h"

namespace eifmap {

// Of the keyframe's landmarks, the share that at least so many other keyframes see; 1 of none.
double redundancy(const Map& map, int keyframe, int enough_views);

// Of the keyframes that see what `reference` sees, the most redundant one, where KeyframeOptions
// has one go; none that an absolute measurement is of. It is the caller's to remove.
std::optional<int> redundant_keyframe(const Map& map, int reference,
                                      const KeyframeOptions& options);

}  // namespace eifmap
