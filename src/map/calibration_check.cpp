#include "map/calibration_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "geometry/robust.h"
#include "map/observed_frame.h"
#include "motion/essential.h"
#include "motion/relative_pose.h"

namespace eifmap {
namespace {

// Focal lengths over the calibration's. Where the camera turns by 10 degrees or more a quarter off
// is too far to explain anything, so that the grid must not be wider.
constexpr std::array kFactors{0.41, 0.512, 0.64, 0.8, 1.0, 1.25, 1.5625, 1.953, 2.44};
constexpr std::size_t kClaimed = 4;
static_assert(kFactors[kClaimed] == 1);

// Log-likelihoods. They are far beyond what chance does to independent residuals (7 would be one in
// a thousand), because residuals of blobs resemble each other.
constexpr double kSuspect = 120, kTrusted = 200, kSpeaksFor = 30;
constexpr int kSupporters = 2;  // one pair may have shown something that moves

constexpr double kTurn = 8 * M_PI / 180;  // with less a pair says little
constexpr std::size_t kMinMatches = 60;
constexpr int kMaxPairs = 60;  // of no verdict by then there will be none
constexpr int kMaxApart = 30;  // keyframes that may still share a view

Camera with_focal(Camera camera, double factor) {
  camera.fx *= factor;
  camera.fy *= factor;
  return camera;
}

std::vector<Correspondence> correspondences(const FeatureFrame& i, const FeatureFrame& j,
                                            std::span<const Match> matches, const Camera& camera,
                                            double sigma_factor) {
  std::vector<Correspondence> result;
  const auto see = [&](const Keypoint& keypoint, Eigen::Vector2d& x, double& sigma) {
    x = camera.normalized_from_pixel({keypoint.u, keypoint.v});
    sigma = x.allFinite() ? sigma_factor * keypoint.sigma_px * camera.radians_per_pixel_at(x) : 0;
    return x.allFinite();
  };
  for (const Match& match : matches) {
    Correspondence c;
    if (see(i.keypoints[match.a], c.x_i, c.sigma_i) && see(j.keypoints[match.b], c.x_j, c.sigma_j))
      result.push_back(c);
  }
  return result;
}

double cost_of(std::span<const Correspondence> matches, const RelativePose& pose) {
  double cost = 0;
  for (const Correspondence& match : matches)
    cost += bisquare_cost(sampson_residual(match, pose), kBisquare);
  return cost;
}

// Of the best pose that is found; nothing explained where there is none.
double least_cost(std::span<const Correspondence> matches, double radians_per_pixel,
                  const RelativePoseOptions& options) {
  const double nothing = static_cast<double>(matches.size()) * bisquare_cost(kBisquare, kBisquare);
  const RotationFit rotation = fit_rotation(matches, radians_per_pixel, options);
  std::optional<RelativePose> pose =
      search_relative_pose(matches, rotation.i_from_j, radians_per_pixel, options);
  if (!pose) return nothing;
  std::vector<std::uint8_t> inlier;
  refine_relative_pose(matches, *pose, inlier, RelativePoseCovariance::kLinear);
  return std::min(nothing, cost_of(matches, *pose));
}

std::vector<Match> all_matches(const ObservedFrame& i, const ObservedFrame& j,
                               const MatchOptions& options) {
  std::vector<Match> matches = match_omega_p(i, j, options);
  const std::vector<Match> more = match_omega_m(i, j, options);
  matches.insert(matches.end(), more.begin(), more.end());
  return matches;
}

}  // namespace

CalibrationCheck::CalibrationCheck(const Camera& camera, const MapperOptions& options)
    : camera_(camera),
      options_(options),
      cost_(kFactors.size(), 0),
      supporters_(kFactors.size(), 0) {}

std::vector<double> CalibrationCheck::costs(const FeatureFrame& i, const FeatureFrame& j,
                                            std::span<const Match> matches) const {
  std::vector<double> result;
  for (std::size_t k = 0; k < kFactors.size(); ++k) {
    if (is_out(k)) {
      result.push_back(0);
      continue;
    }
    const double factor = kFactors[k];
    const Camera camera = with_focal(camera_, factor);
    const auto seen = correspondences(i, j, matches, camera, options_.sigma_factor);
    // A fisheye of a shorter focal length sees less of the image: what is beyond is unexplained.
    const double beyond = static_cast<double>(matches.size() - seen.size());
    double cost = beyond * bisquare_cost(kBisquare, kBisquare);
    if (!seen.empty()) cost += least_cost(seen, camera.radians_per_pixel(), options_.relative_pose);
    result.push_back(cost);
  }
  return result;
}

void CalibrationCheck::add_pair(const FeatureFrame& i, const FeatureFrame& j,
                                std::span<const Match> matches) {
  if (verdict_ != Verdict::kOpen || matches.size() < kMinMatches || pairs_ >= kMaxPairs) return;
  ++pairs_;
  const std::vector<double> cost = costs(i, j, matches);
  for (std::size_t k = 0; k < cost.size(); ++k) {
    if (is_out(k)) continue;
    cost_[k] += cost[k] - cost[kClaimed];
    supporters_[k] += cost[k] - cost[kClaimed] < -kSpeaksFor;
  }
  decide();
}

// So far behind that it need not be tried on any other pair.
bool CalibrationCheck::is_out(std::size_t k) const {
  return cost_[k] > kTrusted;
}

std::size_t CalibrationCheck::best() const {
  return static_cast<std::size_t>(std::min_element(cost_.begin(), cost_.end()) - cost_.begin());
}

void CalibrationCheck::decide() {
  const std::size_t k = best();
  if (cost_[k] < -kSuspect && supporters_[k] >= kSupporters) verdict_ = Verdict::kSuspect;
  double next = std::numeric_limits<double>::max();
  for (std::size_t other = 0; other < cost_.size(); ++other)
    if (other != kClaimed) next = std::min(next, cost_[other]);
  if (next > kTrusted) verdict_ = Verdict::kTrusted;
}

void CalibrationCheck::warn(FrameResult& result) const {
  if (verdict_ != Verdict::kSuspect || result.state != TrackingState::kTracking) return;
  if (result.reason != Reason::kNone) return;
  result.reason = Reason::kCalibrationSuspect;
  result.detail = detail();
}

void CalibrationCheck::look_at(const Map& map) {
  if (verdict_ != Verdict::kOpen) return;
  const std::int64_t begun_us = map.keyframe(0).time_us;
  const int newest = map.num_keyframes() - 1;
  if (begun_us != map_begun_us_) anchor_ = newest_ = 0;
  map_begun_us_ = begun_us;
  if (newest == newest_) return;
  newest_ = newest;
  if (newest - anchor_ > kMaxApart) anchor_ = newest - 1;
  if (map.pose(anchor_).rotation.angularDistance(map.pose(newest).rotation) < kTurn) return;
  const ObservedFrame &i = map.keyframe(anchor_).observed(), &j = map.keyframe(newest).observed();
  add_pair(i.frame, j.frame, all_matches(i, j, options_.match));
  anchor_ = newest;
}

std::string CalibrationCheck::detail() const {
  const std::size_t k = best();
  std::ostringstream text;
  text.precision(3);
  text << "a focal length about " << kFactors[k] << " times as long (" << kFactors[k] * camera_.fx
       << " px) explains the matches of " << supporters_[k] << " of " << pairs_
       << " pairs of keyframes far better";
  return text.str();
}

}  // namespace eifmap
