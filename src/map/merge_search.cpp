#include "map/merge_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "filter/derived_covariances.h"
#include "map/loop_search.h"
#include "map/pose_search.h"
#include "map/share_seen.h"

namespace eifmap {
namespace {

constexpr int kAround = 6;  // keyframes of a place, the one itself among them

// The most alike; before the index is ready, one after the other.
std::vector<int> likely_in(const Map& there, const FeatureFrame& frame, int turn, int count) {
  const std::vector<char> all(static_cast<std::size_t>(there.num_keyframes()), 1);
  if (there.places().ready()) return places_by_look(there, frame, all, count);
  std::vector<int> places;
  const int n = there.num_keyframes();
  for (int i = 0; i < std::min(count, n); ++i)
    if (const int k = (turn * count + i) % n; !there.is_removed(k)) places.push_back(k);
  return places;
}

void refuse_as_unlike(const SeenAgain& seen, LoopFit& fit) {
  fit.reason = Reason::kMergeUnlike;
  fit.detail = "keyframe " + std::to_string(fit.newest) + " at " + std::to_string(fit.old) + ": " +
               seen.in_words();
}

// What the fit's keyframe sees of the old place, and the old place of its.
void check_seen(const Map& there, const Map& here, const SafeView& view,
                const MapperOptions& options, LoopFit& fit) {
  const SeenAgain of_there = seen_again(there, fit.old, here.keyframe(fit.newest).observed(),
                                        fit.world_from_newest.rigid(), view, options);
  const Similarity here_from_old =
      there_from_here(fit, here).inverse() * Similarity::of(there.pose(fit.old));
  const SeenAgain of_here = seen_again(here, fit.newest, there.keyframe(fit.old).observed(),
                                       here_from_old.rigid(), view, options);
  for (const SeenAgain& seen : {of_there, of_here})
    if (!seen.is_all_over(options.lost)) refuse_as_unlike(seen, fit);
}

}  // namespace

const Map* map_of(std::int64_t map_id, const std::vector<KeptView>& kept) {
  for (const KeptView& k : kept)
    if (k.map_id == map_id) return k.map.get();
  return nullptr;
}

Similarity there_from_here(const LoopFit& fit, const Map& here) {
  return fit.world_from_newest * Similarity::of(here.pose(fit.newest)).inverse();
}

bool agree(const LoopFit& a, const LoopFit& b, const Map& there, const Map& here,
           const LoopOptions& options) {
  const double log_ratio = std::log(b.world_from_newest.scale / a.world_from_newest.scale);
  const double scale_variance = a.sigma_log_scale * a.sigma_log_scale +
                                b.sigma_log_scale * b.sigma_log_scale + kScaleFloor * kScaleFloor;
  if (std::abs(log_ratio) > kScaleGate * std::sqrt(scale_variance)) return false;

  PoseBlock of_step;  // here, of b's keyframe in a's
  if (!relative_covariance(here.filter(), a.newest, b.newest, of_step)) return false;
  const Rigid3 a_from_b = here.pose(a.newest).inverse() * here.pose(b.newest);
  const double scale = a.world_from_newest.scale;
  const Eigen::Matrix3d there_from_a = a.world_from_newest.rotation;
  const Eigen::Vector3d step = scale * (there_from_a * a_from_b.translation);
  const Rigid3 found = b.world_from_newest.rigid();
  const Eigen::Quaterniond turned =
      (a.world_from_newest.rigid().rotation * a_from_b.rotation).normalized();
  Eigen::Matrix<double, 6, 1> off;
  off << so3_log(turned.conjugate() * found.rotation),
      found.translation - (a.world_from_newest.translation + step);

  PoseBlock by_a = PoseBlock::Identity();  // what a's own error makes of b's pose
  by_a.topLeftCorner<3, 3>() = a_from_b.rotation.conjugate().toRotationMatrix();
  by_a.bottomLeftCorner<3, 3>() = -scale * (there_from_a * skew(a_from_b.translation));
  PoseBlock by_step = PoseBlock::Identity();
  by_step.bottomRightCorner<3, 3>() = scale * there_from_a;
  const double inflation = options.drift_factor * options.drift_factor;
  PoseBlock covariance = b.covariance + by_a * a.covariance * by_a.transpose() +
                         inflation * (by_step * of_step * by_step.transpose());
  const double floor = kRotationFloor * there.median_depth(b.old);
  covariance.topLeftCorner<3, 3>().diagonal().array() += kRotationFloor * kRotationFloor;
  covariance.bottomRightCorner<3, 3>() += scale_variance * (step * step.transpose());
  covariance.bottomRightCorner<3, 3>().diagonal().array() += floor * floor;
  return off.dot(covariance.ldlt().solve(off)) <= kPoseGate;
}

// What was found is of a map that has changed since.
void MergeSearch::forget_changed(const Map& here, const std::vector<KeptView>& kept) {
  const Map* there = map_of(place_.map_id, kept);
  const bool is_as_before = there && place_.keyframe >= 0 && !there->is_removed(place_.keyframe) &&
                            here.epoch() == epoch_ &&
                            std::none_of(fits_.begin(), fits_.end(), [&](const LoopFit& fit) {
                              return here.is_removed(fit.newest);
                            });
  epoch_ = here.epoch();
  if (is_as_before) return;
  place_ = {};
  seen_ = 0;
  fits_.clear();
}

// First those around what was found before.
std::vector<MergeSearch::Place> MergeSearch::to_try(const Map& here, int newest,
                                                    const std::vector<KeptView>& kept,
                                                    const LoopOptions& options) const {
  std::vector<Place> places;
  if (const Map* there = map_of(place_.map_id, kept))
    for (const int k : there->covisible(place_.keyframe, kAround))
      places.push_back({place_.map_id, k});
  const FeatureFrame& frame = here.keyframe(newest).observed().frame;
  const auto n = kept.size();
  const int of_each = std::max(1, options.max_candidates / static_cast<int>(n));
  for (std::size_t i = 0; i < std::min<std::size_t>(n, options.max_candidates); ++i) {
    const std::size_t at = (static_cast<std::size_t>(turn_) + i) % n;
    for (const int k : likely_in(*kept[at].map, frame, turn_, of_each)) {
      const Place place{kept[at].map_id, k};
      if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
    }
  }
  return places;
}

MapsFit MergeSearch::look(const Map& here, int newest, const std::vector<KeptView>& kept,
                          const SafeView& view, const MapperOptions& options) {
  MapsFit outcome;
  forget_changed(here, kept);
  if (kept.empty()) return outcome;
  Place best;
  int most = options.loop.min_matches - 1;
  const ObservedFrame& observed = here.keyframe(newest).observed();
  for (const Place& place : to_try(here, newest, kept, options.loop)) {
    const Map& there = *map_of(place.map_id, kept);
    const int matched =
        static_cast<int>(landmarks_among(there, place.keyframe,
                                         match_omega_m(there.keyframe(place.keyframe).observed(),
                                                       observed, options.match))
                             .size());
    if (matched > most) most = matched, best = place;
  }
  ++turn_;
  if (best.keyframe < 0 || best.map_id != place_.map_id) {
    fits_.clear();
    seen_ = 0;
  }
  place_ = best;
  if (best.keyframe < 0) return outcome;
  outcome.map_id = best.map_id;
  outcome.found = ++seen_ >= options.loop.consecutive;

  const Map& there = *map_of(best.map_id, kept);
  LoopFit fit = fit_place(there, best.keyframe, here, newest, options);
  if (fit.ok()) check_seen(there, here, view, options, fit);
  const bool agrees = fit.ok() && std::all_of(fits_.begin(), fits_.end(), [&](const LoopFit& f) {
                        return agree(f, fit, there, here, options.loop);
                      });
  outcome.reason = fit.reason;
  outcome.detail = fit.detail;
  if (fit.ok() && !agrees) {
    outcome.reason = Reason::kMergeNotAgreed;
    outcome.detail = "keyframe " + std::to_string(newest) + " at " + std::to_string(fit.old) +
                     ": not as the keyframe before it says";
  }
  if (!agrees) fits_.clear();
  if (fit.ok()) fits_.push_back(std::move(fit));
  if (outcome.reason == Reason::kNone) {
    outcome.found = static_cast<int>(fits_.size()) >= options.loop.consecutive;
    outcome.fits = fits_;
  }
  return outcome;
}

}  // namespace eifmap
