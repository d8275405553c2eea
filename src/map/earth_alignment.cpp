#include "map/earth_alignment.h"

#include <algorithm>
#include <cmath>

#include "geometry/robust.h"
#include "map/map.h"

namespace eifmap {

Similarity fit_positions(const Map& map, const std::vector<const PlacedMeasurement*>& positions) {
  const auto n = static_cast<Eigen::Index>(positions.size());
  const DirectionPair up{Eigen::Vector3d::UnitZ(),
                         map.filter().earth_from_map().matrix().row(2).transpose()};
  const bool is_level = map.filter().has_absolute(AbsoluteObservation::Kind::kDown);
  Eigen::Matrix3Xd a(3, n), b(3, n);
  Similarity found;
  // Levers are metres, the rest is in units of the map: again with the scale found.
  for (int pass = 0; pass < 4; ++pass) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const PlacedMeasurement& m = *positions[static_cast<std::size_t>(k)];
      const PlacedPoint& point = m.points.front();
      const Eigen::Vector3d lever = map.pose(point.keyframe).rotation * point.lever;
      a.col(k) = m.value - (pass > 0 ? Eigen::Vector3d(found.rotation * lever)
                                     : Eigen::Vector3d(Eigen::Vector3d::Zero()));
      b.col(k) = map.pose(point.keyframe) * point.offset;
    }
    found = fit_similarity(a, b, is_level ? &up : nullptr);
  }
  return found;
}

std::optional<EarthAlignment> align_positions(const Map& map, const MeasurementOptions& options) {
  constexpr double kOutlier = 4.6;              // spreads: 1 in 10,000, of three axes
  constexpr double kSpreadFromMedian3d = 0.65;  // of one axis from the median norm of three
  EarthAlignment found;
  for (const PlacedMeasurement& m : map.scale().waiting)
    if (m.kind == MeasurementKind::kPosition) found.inliers.push_back(&m);
  const std::size_t all = found.inliers.size();
  const auto wanted = static_cast<std::size_t>(options.min_positions);
  for (int round = 0; round < 5; ++round) {
    if (found.inliers.size() < wanted || 2 * found.inliers.size() < all) return std::nullopt;
    const Similarity& s = found.earth_from_map = fit_positions(map, found.inliers);
    if (!(s.scale > 0)) return std::nullopt;
    const auto residual = [&](const PlacedMeasurement& m) {
      return (m.value - s * in_map(map, m.points.front(), s.scale)).norm();
    };
    std::vector<double> residuals;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double claimed = 0, squared = 0, spread_out = 0;
    const auto n = static_cast<double>(found.inliers.size());
    for (const PlacedMeasurement* m : found.inliers) {
      residuals.push_back(residual(*m));
      squared += std::pow(residuals.back(), 2);
      claimed += m->covariance.trace() / (3 * n);
      mean += map.pose(m->points.front().keyframe).translation / n;
    }
    for (const PlacedMeasurement* m : found.inliers)
      spread_out += (map.pose(m->points.front().keyframe).translation - mean).squaredNorm();
    const double spread =
        std::max(std::sqrt(claimed), kSpreadFromMedian3d * take_median(residuals));
    const auto first_out = std::stable_partition(
        found.inliers.begin(), found.inliers.end(),
        [&](const PlacedMeasurement* m) { return residual(*m) <= kOutlier * spread; });
    if (first_out == found.inliers.end()) {
      const double variance = std::max(claimed, squared / (3 * n - 7));
      const double sigma = std::sqrt(variance / spread_out) / s.scale;
      return sigma <= options.max_scale_sigma ? std::optional(found) : std::nullopt;
    }
    found.outliers.insert(found.outliers.end(), first_out, found.inliers.end());
    found.inliers.erase(first_out, found.inliers.end());
  }
  return std::nullopt;
}

std::optional<Level> find_level(const Map& map) {
  constexpr std::size_t kWanted = 3, kLatest = 100;
  constexpr double kSigmas = 4.3;  // 1 in 10,000, of two axes
  constexpr double kBent = 0.01;   // rad, what keyframes of a young map may be turned by
  struct Direction {
    const PlacedMeasurement* of;
    Eigen::Vector3d up;
    double variance;
  };
  std::vector<Direction> all;
  const std::vector<PlacedMeasurement>& waiting = map.scale().waiting;
  for (auto at = waiting.rbegin(); at != waiting.rend() && all.size() < kLatest; ++at) {
    const PlacedMeasurement& m = *at;
    if (m.kind != MeasurementKind::kGravity) continue;
    const PlacedMeasurement now = of_present(map, m);
    all.push_back({&m, -(map.pose(now.points.front().keyframe).rotation * now.value),
                   now.covariance.trace() / 3 + kBent * kBent});
  }
  const auto agree = [](const Direction& a, const Direction& b) {
    const double angle = std::atan2(a.up.cross(b.up).norm(), a.up.dot(b.up));
    return angle <= kSigmas * std::sqrt(a.variance + b.variance);
  };
  const Direction* best = nullptr;
  std::ptrdiff_t most = 0;
  for (const Direction& direction : all) {
    const auto agreeing = std::count_if(
        all.begin(), all.end(), [&](const Direction& other) { return agree(direction, other); });
    if (agreeing > most) best = &direction, most = agreeing;
  }
  const auto count = static_cast<std::size_t>(most);
  if (count < kWanted || 2 * count <= all.size()) return std::nullopt;
  Level level{Eigen::Vector3d::Zero(), {}};
  for (const Direction& direction : all) {
    if (!agree(*best, direction)) continue;
    level.inliers.push_back(direction.of);
    level.up_in_map += direction.up / direction.variance;
  }
  level.up_in_map.normalize();
  return level;
}

}  // namespace eifmap
