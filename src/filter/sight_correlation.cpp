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
std::vector<Eigen::Vector2d> residuals_of(const FilterLandmark& landmark,
                                          const std::vector<Rigid3>& poses) {
  std::vector<std::pair<int, Eigen::Vector2d>> with_pose;
  for (const PointMeasurement& m : landmark.measurements) {
    Eigen::Vector2d predicted;
    if (project(poses[static_cast<std::size_t>(m.pose)], landmark.position, predicted))
      with_pose.emplace_back(m.pose, (m.x - predicted) / m.sigma);
  }
  std::sort(with_pose.begin(), with_pose.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Eigen::Vector2d> residuals;
  for (const auto& [pose, residual] : with_pose) residuals.push_back(residual);
  return residuals;
}

}  // namespace

void CorrelationSums::set(int landmark, const FilterLandmark& of,
                          const std::vector<Rigid3>& poses) {
  const auto at = static_cast<std::size_t>(landmark);
  while (at >= tracks_.size()) tracks_.push_back({});
  OfTrack& track = tracks_.write(at);
  track = {};
  if (of.measurements.size() < kShortest) return;
  const std::vector<Eigen::Vector2d> r = residuals_of(of, poses);
  if (r.size() < kShortest) return;
  track.sights = static_cast<double>(r.size());
  track.pairs = track.sights - 1;
  for (std::size_t k = 0; k < r.size(); ++k) {
    track.squares += r[k].squaredNorm();
    if (k > 0) track.products += r[k].dot(r[k - 1]);
  }
}

SightCorrelation CorrelationSums::correlation() const {
  double sights = 0, pairs = 0, squares = 0, products = 0, lengths = 0;
  for (const OfTrack& track : tracks_) {
    sights += track.sights;
    pairs += track.pairs;
    squares += track.squares;
    products += track.products;
    lengths += track.sights * track.sights;
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
