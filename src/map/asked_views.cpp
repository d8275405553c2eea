#include "map/asked_views.h"

#include "filter/derived_covariances.h"

namespace eifmap {

std::optional<RelativeView> relative_view(const Map& map, std::int64_t a, std::int64_t b) {
  const auto in_use = [&map](std::int64_t k) {
    return k >= 0 && k < map.num_keyframes() && !map.is_removed(static_cast<int>(k));
  };
  if (!in_use(a) || !in_use(b)) return std::nullopt;
  const int from = static_cast<int>(a), to = static_cast<int>(b);
  PoseBlock covariance;
  if (!relative_covariance(map.filter(), from, to, covariance)) return std::nullopt;
  return RelativeView{map.pose(from).inverse() * map.pose(to), centre_first(covariance)};
}

std::optional<EarthView> earth_view(const Map& map) {
  const InformationFilter& filter = map.filter();
  if (!filter.has_level()) return std::nullopt;
  const bool certain = earth_is_certain(filter);
  EarthView view;
  view.earth_from_map = filter.earth_from_map();
  view.placed = filter.has_earth();
  for (int k = 0; k < map.num_keyframes(); ++k) {
    if (map.is_removed(k)) continue;
    EarthView::Keyframe& keyframe = view.keyframes.emplace_back();
    keyframe.id = k;
    keyframe.time_us = map.keyframe(k).time_us;
    keyframe.earth_from_camera = view.earth_from_map * map.pose(k);
    PoseBlock covariance;
    if (certain && covariance_in_earth(filter, k, covariance))
      keyframe.covariance = centre_first(covariance);
  }
  for (int t = 0; t < map.num_tracks(); ++t) {
    if (!map.track(t).is_landmark()) continue;
    EarthView::Landmark& landmark = view.landmarks.emplace_back();
    landmark.id = t;
    landmark.position = view.earth_from_map * map.position(t);
    Eigen::Matrix3d covariance;
    if (certain && landmark_covariance_in_earth(filter, map.track(t).landmark, covariance))
      landmark.covariance = covariance;
  }
  return view;
}

}  // namespace eifmap
