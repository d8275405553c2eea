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
  constexpr double kFar = 1e9;  // m; beyond the moon, and its square is far from overflowing
  if (m.kind != MeasurementKind::kPosition) {
    if (!(m.length > 0 && m.length <= kFar) || m.until_us <= m.time_us)
      return Reason::kBadMeasurement;
    return m.sigma <= kFar && m.sigma * m.sigma > 0 ? Reason::kNone
                                                    : Reason::kBadMeasurementCovariance;
  }
  const auto is_near = [](const Eigen::Vector3d& v) { return v.cwiseAbs().maxCoeff() <= kFar; };
  if (!m.position.allFinite() || !m.lever.allFinite() || !is_near(m.position) || !is_near(m.lever))
    return Reason::kBadMeasurement;
  const Eigen::Matrix3d& c = m.covariance;
  const bool usable = c.allFinite() && c.diagonal().maxCoeff() <= kFar * kFar &&
                      (c - c.transpose()).norm() <= 1e-9 * c.norm() &&
                      Eigen::LLT<Eigen::Matrix3d>(c).info() == Eigen::Success;
  return usable ? Reason::kNone : Reason::kBadMeasurementCovariance;
}

MeasurementCounts& MeasurementCounts::operator+=(const MeasurementCounts& other) {
  for (const auto& [kind, count] : other.kinds) {
    kinds[kind].used += count.used;
    kinds[kind].refused += count.refused;
    kinds[kind].dropped += count.dropped;
  }
  for (const auto& [reason, count] : other.refusals) refusals[reason] += count;
  return *this;
}

}  // namespace eifmap
