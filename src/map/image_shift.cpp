#include "map/image_shift.h"

#include <limits>

#include "geometry/projection.h"
#include "geometry/robust.h"

namespace eifmap {
namespace {

// One per sight; not finite for a landmark that is behind one of the poses.
std::vector<Eigen::Vector2d> shifts_of(const Map& map, const std::vector<LandmarkSight>& sights,
                                       const Rigid3& from, const Rigid3& to) {
  const Projector before(from), after(to);
  std::vector<Eigen::Vector2d> shifts;
  shifts.reserve(sights.size());
  for (const LandmarkSight& sight : sights) {
    const Eigen::Vector3d& position = map.position(sight.track);
    Eigen::Vector2d a, b;
    if (before(position, a) && after(position, b))
      shifts.emplace_back(b - a);
    else
      shifts.emplace_back(Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
  }
  return shifts;
}

}  // namespace

Eigen::Vector2d median_step(const Map& map, const std::vector<LandmarkSight>& sights,
                            const Rigid3& from, const Rigid3& to) {
  std::vector<double> x, y;
  for (const Eigen::Vector2d& shift : shifts_of(map, sights, from, to)) {
    if (!shift.allFinite()) continue;
    x.push_back(shift.x());
    y.push_back(shift.y());
  }
  return {take_median(x), take_median(y)};
}

double median_shift(const Map& map, const std::vector<LandmarkSight>& sights, const Rigid3& a,
                    const Rigid3& b) {
  std::vector<double> lengths;
  for (const Eigen::Vector2d& shift : shifts_of(map, sights, a, b)) lengths.push_back(shift.norm());
  return take_median(lengths);
}

}  // namespace eifmap
