#include "map/loop_gate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "filter/derived_covariances.h"
#include "geometry/robust.h"
#include "map/image_shift.h"
#include "map/loop_search.h"
#include "map/other_place.h"
#include "map/pose_search.h"

namespace eifmap {
namespace {

void refuse(LoopFit& fit, Reason reason, const std::string& detail) {
  fit.reason = reason;
  fit.detail =
      "keyframe " + std::to_string(fit.newest) + " at " + std::to_string(fit.old) + ": " + detail;
}

// Of a grid of 4 x 4 over what the landmarks' image spans at most, the cells that have some.
int cells_with_sights(const ObservedFrame& observed, const std::vector<LandmarkSight>& sights) {
  Eigen::Vector2d low = observed.x.front(), high = low;
  for (const Eigen::Vector2d& x : observed.x) low = low.cwiseMin(x), high = high.cwiseMax(x);
  std::array<int, 16> count{};
  for (const LandmarkSight& s : sights) {
    const Eigen::Vector2d at =
        4 * (observed.x[s.keypoint] - low).cwiseQuotient((high - low).cwiseMax(1e-9));
    const int column = std::clamp(static_cast<int>(at.x()), 0, 3);
    const int row = std::clamp(static_cast<int>(at.y()), 0, 3);
    ++count[static_cast<std::size_t>(4 * row + column)];
  }
  return static_cast<int>(std::count_if(count.begin(), count.end(), [](int n) { return n > 0; }));
}

// Logarithms of old over new depth, of features that are landmarks on both sides.
std::vector<double> log_depth_ratios(const Map& there, const Map& here, const LoopFit& fit) {
  const Rigid3 from_old = fit.world_from_newest.rigid().inverse();
  const Rigid3 from_new = here.pose(fit.newest).inverse();
  std::vector<double> ratios;
  for (const LandmarkSight& s : fit.sights) {
    const int own = here.keyframe(fit.newest).track[s.keypoint];
    const bool is_same = &there == &here && own == s.track;
    if (own == kNoTrack || is_same || !here.track(own).is_landmark()) continue;
    const double z_old = (from_old * there.position(s.track)).z();
    const double z_new = (from_new * here.position(own)).z();
    if (z_old > 0 && z_new > 0) ratios.push_back(std::log(z_old / z_new));
  }
  return ratios;
}

void fit_scale(const Map& there, const Map& here, const LoopOptions& options, LoopFit& fit) {
  std::vector<double> ratios = log_depth_ratios(there, here, fit);
  const auto n = static_cast<double>(ratios.size());
  if (static_cast<int>(ratios.size()) < options.min_scale_pairs)
    return refuse(fit, Reason::kLoopScaleUncertain,
                  std::to_string(ratios.size()) + " features have a depth on both sides");
  const double median = take_median(ratios);
  for (double& r : ratios) r = std::abs(r - median);
  const double spread = kSpreadFromMedian1d * take_median(ratios);
  fit.sigma_log_scale = 1.25 * spread / std::sqrt(n);  // a median's, of normal errors
  fit.world_from_newest.scale = std::exp(median);
  if (fit.sigma_log_scale <= options.max_scale_sigma) return;
  std::ostringstream detail;
  detail << "the depths on both sides differ by a factor of " << fit.world_from_newest.scale
         << " with a spread of " << spread << " over " << ratios.size();
  refuse(fit, Reason::kLoopScaleUncertain, detail.str());
}

// The keyframe's surroundings that share its scale.
std::vector<int> surroundings(const Map& map, int keyframe) {
  constexpr int kMost = 8;
  return map.covisible(keyframe, kMost);
}

// Variance of how much the one's scale drifts against the other's, by the filter.
bool scale_drift_variance(const Map& map, int old, int newest, double& variance) {
  std::vector<PoseSensitivity> sensitivities;
  for (const auto& [keyframe, sign] : {std::pair(newest, 1.0), std::pair(old, -1.0)}) {
    const std::vector<int> poses = surroundings(map, keyframe);
    Eigen::Matrix3Xd to_centres;
    if (!log_scale_derivative(map.filter(), poses, to_centres)) return false;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      PoseSensitivity s{poses[k], PoseBlock::Zero()};
      s.derivative.block<1, 3>(0, 3) =
          sign * to_centres.col(static_cast<Eigen::Index>(k)).transpose();
      sensitivities.push_back(s);
    }
  }
  PoseBlock covariance;
  if (!map.filter().propagate(sensitivities, covariance)) return false;
  variance = covariance(0, 0);
  return true;
}

// By the index of places; before that is ready, all over the map.
std::vector<int> most_alike(const Map& map, const FeatureFrame& frame,
                            const std::vector<char>& allowed, int count) {
  if (map.places().ready()) return places_by_look(map, frame, allowed, count);
  std::vector<int> all, some;
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (allowed[k]) all.push_back(k);
  const auto most = static_cast<std::size_t>(count);
  const std::size_t step = std::max<std::size_t>(1, (all.size() + most - 1) / most);
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

double way_between(const Map& map, int from, int to) {
  double length = 0;
  for (int k = from, last = from; k <= to; ++k) {
    if (map.is_removed(k)) continue;
    length += (map.pose(k).translation - map.pose(last).translation).norm();
    last = k;
  }
  return length;
}

}  // namespace

LoopFit fit_place(const Map& there, int old, const Map& here, int newest,
                  const MapperOptions& options) {
  LoopFit fit;
  fit.old = old;
  fit.newest = newest;
  const ObservedFrame& observed = here.keyframe(newest).observed();
  const LastMotion unknown;
  const PoseSearch search(there, observed, unknown, options);
  const std::vector<LandmarkSight> matched = landmarks_among(
      there, old, match_omega_m(there.keyframe(old).observed(), observed, options.match));
  Tracking found;
  found.reference = found.related = old;
  const bool is_posed = search.by_pnp(matched, PoseSource::kRelocalized, found);
  if (!is_posed || static_cast<int>(found.sights.size()) < options.loop.min_inliers) {
    refuse(fit, Reason::kLoopTooFewInliers,
           std::to_string(is_posed ? found.sights.size() : 0) + " map features agree, of " +
               std::to_string(matched.size()) + " matched");
    return fit;
  }
  fit.sights = std::move(found.sights);
  fit.covariance = found.covariance;
  fit.world_from_newest = Similarity::of(found.world_from_camera);
  if (const int cells = cells_with_sights(observed, fit.sights); cells < options.loop.min_cells) {
    refuse(fit, Reason::kLoopOneSpot,
           std::to_string(fit.sights.size()) + " map features agree, in " + std::to_string(cells) +
               " of 16 parts of the image");
    return fit;
  }
  fit_scale(there, here, options.loop, fit);
  return fit;
}

LoopFit fit_loop(const Map& map, int old, int newest, const MapperOptions& options) {
  return fit_place(map, old, map, newest, options);
}

void check_possible(const Map& map, const LoopOptions& options, LoopFit& fit) {
  PoseBlock of_map;
  double of_scale = 0;
  if (!relative_covariance(map.filter(), fit.old, fit.newest, of_map) ||
      !scale_drift_variance(map, fit.old, fit.newest, of_scale))
    return refuse(fit, Reason::kLoopImpossible, "the filter has no covariance of them");
  const Rigid3& now = map.pose(fit.newest);
  const Rigid3 found = fit.world_from_newest.rigid();
  const Eigen::Matrix3d to_old = map.pose(fit.old).matrix().transpose();
  Eigen::Matrix<double, 6, 1> off;
  off << so3_log(now.rotation.conjugate() * found.rotation),
      to_old * (found.translation - now.translation);
  PoseBlock turn = PoseBlock::Identity();
  turn.bottomRightCorner<3, 3>() = to_old;
  const double inflation = options.drift_factor * options.drift_factor;
  PoseBlock covariance = inflation * of_map + turn * fit.covariance * turn.transpose();
  const double floor = options.drift_share * way_between(map, fit.old, fit.newest);
  covariance.topLeftCorner<3, 3>().diagonal().array() += kRotationFloor * kRotationFloor;
  covariance.bottomRightCorner<3, 3>().diagonal().array() += floor * floor;
  const double squared = off.dot(covariance.ldlt().solve(off));
  const double log_scale = std::log(fit.world_from_newest.scale);
  const double scale_sigma = std::sqrt(inflation * of_scale + kScaleFloor * kScaleFloor +
                                       fit.sigma_log_scale * fit.sigma_log_scale);
  if (squared <= kPoseGate && std::abs(log_scale) <= kScaleGate * scale_sigma) return;
  std::ostringstream detail;
  detail << "off by " << off.tail<3>().norm() << " and " << off.head<3>().norm()
         << " rad, chi-square " << squared << ", and in scale by a factor of "
         << fit.world_from_newest.scale << ", " << std::abs(log_scale) / scale_sigma << " sigma";
  refuse(fit, Reason::kLoopImpossible, detail.str());
}

void check_only_place(const Map& map, const MapperOptions& options, LoopFit& fit) {
  check_only_place(map, map.keyframe(fit.newest).observed(),
                   may_close(map, fit.newest, options.loop), options, fit);
}

void check_only_place(const Map& map, const ObservedFrame& observed, std::vector<char> elsewhere,
                      const MapperOptions& options, LoopFit& fit) {
  const std::vector<int> of_place = map.num_shared(fit.old);
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (of_place[k] > 0 || k == fit.old) elsewhere[k] = 0;
  const LastMotion unknown;
  const PoseSearch search(map, observed, unknown, options);
  const int agree = static_cast<int>(fit.sights.size());
  for (const int k : most_alike(map, observed.frame, elsewhere, options.loop.max_compared)) {
    const std::vector<LandmarkSight> matched =
        landmarks_among(map, k, match_omega_m(map.keyframe(k).observed(), observed, options.match));
    if (static_cast<int>(matched.size()) < options.loop.min_matches) continue;
    Tracking found;
    found.reference = found.related = k;
    if (!search.by_pnp(matched, PoseSource::kRelocalized, found)) continue;
    const int here = static_cast<int>(found.sights.size());
    // What is around the old place, too, is not another one.
    if (choose_place(agree, here) == PlaceChoice::kFar ||
        median_shift(map, fit.sights, fit.world_from_newest.rigid(), found.world_from_camera) <=
            search_radius(map, options))
      continue;
    return refuse(fit, Reason::kLoopAmbiguous,
                  std::to_string(agree) + " map features agree, and " + std::to_string(here) +
                      " with keyframe " + std::to_string(k));
  }
}

}  // namespace eifmap
