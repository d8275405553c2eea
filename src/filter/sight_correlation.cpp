#include "filter/sight_correlation.h"

#include <algorithm>

#include "geometry/projection.h"

namespace eifmap {
namespace {

constexpr std::size_t kShortest = 6;  // sights of a track that is counted
constexpr double kLargest = 0.9;
// What is assumed until the map can tell, as if so many neighbours had shown it.
constexpr double kUsual = 0.6, kUsualCount = 300;

struct SeenFrom {
  int pose = 0;
  double along = 0;  // where on the line that order_by_viewpoint() says
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // whitened
};

// Where a blob seems to be depends on where it is seen from, not on when: errors of a second pass
// of a place are those of the first again (rendered block, two laps: of sights less than a degree
// apart, one of either lap, correlation .56, and from then on the same as within a lap). By time,
// rho of such a run came out at .39 with its loop closed and at .65 without. So neighbours are
// those along the line from the first camera to the one furthest from it.
void order_by_viewpoint(std::vector<SeenFrom>& sights, const std::vector<Rigid3>& poses) {
  const auto centre = [&](const SeenFrom& s) -> const Eigen::Vector3d& {
    return poses[static_cast<std::size_t>(s.pose)].translation;
  };
  const auto by_time = [](const SeenFrom& a, const SeenFrom& b) { return a.pose < b.pose; };
  if (sights.empty()) return;
  const Eigen::Vector3d first = centre(*std::min_element(sights.begin(), sights.end(), by_time));
  Eigen::Vector3d line = Eigen::Vector3d::Zero();
  for (const SeenFrom& s : sights)
    if ((centre(s) - first).squaredNorm() > line.squaredNorm()) line = centre(s) - first;
  for (SeenFrom& s : sights) s.along = line.dot(centre(s) - first);
  std::sort(sights.begin(), sights.end(), [&](const SeenFrom& a, const SeenFrom& b) {
    return a.along != b.along ? a.along < b.along : by_time(a, b);
  });
}

// Whitened residuals in the order of where the sights are from.
std::vector<Eigen::Vector2d> residuals_of(const FilterLandmark& landmark,
                                          const std::vector<Rigid3>& poses) {
  std::vector<SeenFrom> sights;
  for (const PointMeasurement& m : landmark.measurements) {
    Eigen::Vector2d predicted;
    if (project(poses[static_cast<std::size_t>(m.pose)], landmark.position, predicted))
      sights.push_back({m.pose, 0, (m.x - predicted) / m.sigma});
  }
  order_by_viewpoint(sights, poses);
  std::vector<Eigen::Vector2d> residuals;
  for (const SeenFrom& s : sights) residuals.push_back(s.residual);
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
  return {std::clamp(all, 0.0, kLargest), length};
}

}  // namespace eifmap
