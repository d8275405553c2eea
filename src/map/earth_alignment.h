// Where measurements that wait put the map in earth: its scale and place by positions, its level by
// gravity. Found by consensus, since there is no map yet that could contradict a wrong one.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/similarity.h"
#include "map/placed_measurement.h"
#include "options.h"

namespace eifmap {

struct EarthAlignment {
  Similarity earth_from_map;
  std::vector<const PlacedMeasurement*> inliers, outliers;  // of the map's, that wait
};

// By positions: the similarity that brings the map to them, when they determine its scale well
// enough. The errors are taken from the residuals, which have the map's own in them, but for no
// less than what the positions claim. A level map stays so.
std::optional<EarthAlignment> align_positions(const Map& map, const MeasurementOptions& options);

// The same by positions that are given; its scale too, whatever the map's is.
Similarity fit_positions(const Map& map, const std::vector<const PlacedMeasurement*>& positions);

struct Level {
  Eigen::Vector3d up_in_map;                      // unit
  std::vector<const PlacedMeasurement*> inliers;  // of the map's, that wait
};

// By gravity: three that agree, and most of the latest that wait.
std::optional<Level> find_level(const Map& map);

}  // namespace eifmap
