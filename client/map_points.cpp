#include "client/map_points.h"

namespace eifmap {

std::vector<MapPoint> points_of(const PublishedMap& map) {
  std::vector<MapPoint> points;
  points.reserve(map.landmarks().size());
  for (const auto& [id, landmark] : map.landmarks()) {
    MapPoint point;
    if (!position_in_map(map, landmark.value, point.position.data())) continue;
    point.laplacian_sign = landmark.value.laplacian_sign;
    point.num_observations = static_cast<int>(landmark.observations.size());
    points.push_back(point);
  }
  return points;
}

}  // namespace eifmap
