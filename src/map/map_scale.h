// How absolute measurements make a map metric: [WD10] IV, "any absolute measurement"; and level.
#pragma once

#include <vector>

#include "map/placed_measurement.h"
#include "options.h"

namespace eifmap {

class Map;

// A part of the map.
struct MapScale {
  ScaleState state;
  EarthState earth;
  // Of the scale; positions of where earth is; gravity of some that agree.
  std::vector<PlacedMeasurement> waiting;
  // Those that contradicted the map: again, when others have said how far the map may be believed.
  std::vector<PlacedMeasurement> contradicting;
  MeasurementCounts counts;
};

// Those that the map can take already enter its filter, gated, before its next update; others wait
// in the map.
void add_measurements(Map& map, std::vector<PlacedMeasurement> measurements,
                      const MeasurementOptions& options);

// Whether a keyframe may go, and its absolute measurements with it: it has none, or such alone as
// scale and earth do not rest on, since another keyframe that sees the same has positions, and
// gravity, too, and the scale is far surer than a map becomes metric by.
bool is_spare(const Map& map, int keyframe);

// Where the measurements that wait determine level, scale and earth, the whole map becomes metric,
// they enter, and the filter is updated. kNone, also when they do not; or kFilterFailed, and the
// map is not to be trusted.
Reason fix_scale(Map& map, const MeasurementOptions& options);

// Writes what the map's scale and its place in earth are known to; after fix_scale() once more
// where the map has changed as a whole.
void judge_scale(Map& map, const MeasurementOptions& options);

}  // namespace eifmap
