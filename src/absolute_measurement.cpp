#include "absolute_measurement.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace eifmap {

std::string_view name(MeasurementKind kind) {
  switch (kind) {
    case MeasurementKind::kPosition:
      return "position";
    case MeasurementKind::kDistance:
      return "distance";
    case MeasurementKind::kOdometry:
      break;
  }
  return "odometry";
}

Reason check_measurement(const AbsoluteMeasurement& m) {
  if (m.kind != MeasurementKind::kPosition) {
    if (!(m.length > 0) || !std::isfinite(m.length) || m.until_us <= m.time_us)
      return Reason::kBadMeasurement;
    return m.sigma > 0 && std::isfinite(m.sigma) ? Reason::kNone
                                                 : Reason::kBadMeasurementCovariance;
  }
  if (!m.position.allFinite() || !m.lever.allFinite()) return Reason::kBadMeasurement;
  const Eigen::Matrix3d& c = m.covariance;
  const bool usable = c.allFinite() && (c - c.transpose()).norm() <= 1e-9 * c.norm() &&
                      Eigen::LLT<Eigen::Matrix3d>(c).info() == Eigen::Success;
  return usable ? Reason::kNone : Reason::kBadMeasurementCovariance;
}

MeasurementCounts& MeasurementCounts::operator+=(const MeasurementCounts& other) {
  for (const auto& [kind, count] : other.kinds) {
    kinds[kind].used += count.used;
    kinds[kind].refused += count.refused;
  }
  for (const auto& [reason, count] : other.refusals) refusals[reason] += count;
  return *this;
}

}  // namespace eifmap
