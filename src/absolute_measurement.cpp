#include "absolute_measurement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace eifmap {

std::string_view name(MeasurementKind kind) {
  switch (kind) {
    case MeasurementKind::kPosition:
      return "position";
    case MeasurementKind::kDistance:
      return "distance";
    case MeasurementKind::kGravity:
      return "gravity";
    case MeasurementKind::kLandmarks:
      return "landmarks";
    case MeasurementKind::kOdometry:
      break;
  }
  return "odometry";
}

namespace {

constexpr double kFar = 1e9;  // m; beyond the moon, and its square is far from overflowing

Reason check_sigma(double sigma, double most) {
  return sigma <= most && sigma > 0 && sigma * sigma > 0 ? Reason::kNone
                                                         : Reason::kBadMeasurementCovariance;
}

Reason check_length(const AbsoluteMeasurement& m) {
  if (!(m.length > 0 && m.length <= kFar)) return Reason::kBadMeasurement;
  if (has_two_times(m.kind) && m.until_us <= m.time_us) return Reason::kBadMeasurement;
  if (m.kind == MeasurementKind::kLandmarks &&
      (m.map_id <= 0 || std::min(m.landmark[0], m.landmark[1]) < 0 ||
       m.landmark[0] == m.landmark[1]))
    return Reason::kBadMeasurement;
  return check_sigma(m.sigma, kFar);
}

Reason check_gravity(const AbsoluteMeasurement& m) {
  constexpr double kLittle = 1e-6, kMostSigma = 1;  // rad: with more it says nothing
  const double size = m.down.norm();
  if (!(size >= kLittle && size <= kFar)) return Reason::kBadMeasurement;
  return check_sigma(m.sigma, kMostSigma);
}

}  // namespace

Reason check_measurement(const AbsoluteMeasurement& m) {
  if (is_length(m.kind)) return check_length(m);
  if (m.kind == MeasurementKind::kGravity) return check_gravity(m);
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
