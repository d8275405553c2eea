#include "motion/epipolar_fit.h"

#include "geometry/rigid3.h"
#include "geometry/robust.h"
#include "motion/epipolar_geometry.h"

namespace eifmap {

EpipolarNormal linearize(std::span<const Correspondence> matches,
                         const std::vector<EpipolarMember>& members, const RelativePose& pose,
                         double limit) {
  const EpipolarGeometry geometry(pose);
  EpipolarNormal normal;
  RowVector5d jacobian;
  for (const EpipolarMember& m : members) {
    const double residual = geometry.residual(matches[m.match], &jacobian);
    normal.cost += m.trust * bisquare_cost(residual, limit);
    const double weight = m.trust * bisquare_weight(residual, limit);
    if (weight == 0) continue;
    normal.information.noalias() += weight * jacobian.transpose() * jacobian;
    normal.gradient.noalias() -= weight * residual * jacobian.transpose();
  }
  return normal;
}

RelativePose moved(const RelativePose& pose, const Vector5d& step) {
  RelativePose result = pose;
  result.i_from_j = (pose.i_from_j * so3_exp(step.head<3>())).normalized();
  result.direction = sphere_retract(pose.direction, step.tail<2>());
  return result;
}

}  // namespace eifmap
