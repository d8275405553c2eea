#include "motion/triangulated_scale.h"

#include "geometry/robust.h"
#include "geometry/triangulation.h"

namespace eifmap {

std::optional<Rigid3> place_by_triangulation(const Rigid3& world_from_i, const RelativePose& pose,
                                             const std::vector<SeenTwice>& features) {
  const Rigid3 i_from_world = world_from_i.inverse();
  const Rigid3 i_from_j(pose.i_from_j, pose.direction);  // a baseline of 1
  std::vector<double> lengths;
  for (const SeenTwice& feature : features) {
    const Correspondence& m = feature.match;
    const Sighting sightings[] = {{Rigid3(), m.x_i, m.sigma_i}, {i_from_j, m.x_j, m.sigma_j}};
    const TriangulatedPoint point = triangulate(sightings);
    const double in_map = (i_from_world * feature.point).z();
    if (point.valid && in_map > 0) lengths.push_back(in_map / point.point.z());
  }
  if (lengths.empty() || 2 * lengths.size() < features.size()) return std::nullopt;
  const double length = take_median(lengths);
  return world_from_i * Rigid3(pose.i_from_j, length * pose.direction);
}

}  // namespace eifmap
