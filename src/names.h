// The names that reports and status messages use.
#pragma once

#include <string_view>

#include "map_view.h"

namespace eifmap {

std::string_view name(PoseSource source);    // "SCALE_FIT", ...
std::string_view name(TrackingState state);  // "TRACKING", ...
std::string_view name(InnovationKind kind);  // "sights", ...
std::string_view name(ScaleStatus status);   // "arbitrary", "metric"
std::string_view name(EarthStatus status);   // "unknown", "level", "placed"

}  // namespace eifmap
