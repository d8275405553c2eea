#include "filter/sight_correlation.h"

#include <algorithm>

#include "geometry/projection.h"

namespace eifmap {
namespace {

constexpr std::size_t kShortest = 6;  // sights of a track that is counted
constexpr double kLargest = 0.9;
// What is assumed until the map can tell, as if so many neighbours had shown it.
constexpr double kUsual = 0.6, kUsualCount = 300;

// Whitened residuals in the order of the keyframes.
void residuals_of(const FilterLandmark& landmark, const std::vector<Projector>& projectors,
                  std::vector<std::pair<int, Eigen::Vector2d>>& residuals) {
  residuals.clear();
  for (const PointMeasurement& m : landmark.measurements) {
    Eigen::Vector2d predicted;
    if (projectors[static_cast<std::size_t>(m.pose)](landmark.position, predicted))
      residuals.emplace_back(m.pose, (m.x - predicted) / m.sigma);
  }
  std::sort(residuals.begin(), residuals.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
}

}  // namespace

SightCorrelation measure_correlation(const std::vector<FilterLandmark>& landmarks,
                                     const std::vector<Rigid3>& poses) {
  std::vector<Projector> projectors;
  projectors.reserve(poses.size());
  for (const Rigid3& pose : poses) projectors.emplace_back(pose);
  double sights = 0, pairs = 0, squares = 0, products = 0, lengths = 0;
  std::vector<std::pair<int, Eigen::Vector2d>> r;
  for (const FilterLandmark& landmark : landmarks) {
    if (landmark.measurements.size() < kShortest) continue;
    residuals_of(landmark, projectors, r);
    if (r.size() < kShortest) continue;
    lengths += static_cast<double>(r.size() * r.size());
    for (std::size_t k = 0; k < r.size(); ++k) {
      ++sights;
      squares += r[k].second.squaredNorm();
      if (k == 0) continue;
      ++pairs;
      products += r[k].second.dot(r[k - 1].second);
    }
  }
  if (!(squares > 0)) return {kUsual};
  // The point took the mean of its track's errors with it, which lowers the autocorrelation of what
  // is left by (1 + 3 rho) / n (M. G. Kendall, Biometrika 1954).
  const double length = lengths / sights;  // of the track that the average sight is in
  const double seen = products / pairs / (squares / sights);
  const double rho = (seen + 1 / length) / (1 - 3 / length);
  const double all = (pairs * rho + kUsualCount * kUsual) / (pairs + kUsualCount);
  return {std::clamp(all, 0.0, kLargest)};
}

}  // namespace eifmap
