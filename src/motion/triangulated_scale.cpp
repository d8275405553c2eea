#include "motion/triangulated_scale.h"

#include "motion/robust.h"

namespace eifmap {
namespace {

// Depth in i of the rays' closest approach, in units of the baseline: z_i a - z_j b = t.
double triangulated_depth(const RelativePose& pose, const DepthRatio& feature) {
  const Eigen::Vector3d a = feature.x_i.homogeneous();
  const Eigen::Vector3d b = pose.i_from_j * feature.x_j.homogeneous();
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-12 * aa * bb)) return 0;
  const double at = a.dot(pose.direction), bt = b.dot(pose.direction);
  const double z_i = (bb * at - ab * bt) / determinant;
  const double z_j = (ab * at - aa * bt) / determinant;
  return z_i > 0 && z_j > 0 ? z_i : 0;
}

}  // namespace

std::optional<Rigid3> place_by_triangulation(const Rigid3& world_from_i, const RelativePose& pose,
                                             const std::vector<DepthRatio>& features) {
  const Rigid3 i_from_world = world_from_i.inverse();
  std::vector<double> lengths;
  for (const DepthRatio& feature : features) {
    const double depth = triangulated_depth(pose, feature);
    const double in_map = (i_from_world * feature.point).z();
    if (depth > 0 && in_map > 0) lengths.push_back(in_map / depth);
  }
  if (lengths.empty() || 2 * lengths.size() < features.size()) return std::nullopt;
  const double length = take_median(lengths);
  return world_from_i * Rigid3(pose.i_from_j, length * pose.direction);
}

}  // namespace eifmap
