#include "map/map_merge.h"

#include <algorithm>
#include <utility>

#include "map/loop_join.h"
#include "map/loop_search.h"
#include "map/map_scale.h"
#include "map/map_settling.h"
#include "map/share_seen.h"

namespace eifmap {
namespace {

constexpr int kAround = 12;  // keyframes of a pass whose landmarks are joined with the other's

// The maps' sights that must be left when the filter has found the mean of both: where two places
// only look alike, what is around them contradicts.
constexpr double kSightsLeft = 0.9;

// The sights of one keyframe in the old place's landmarks, as the merged map numbers them.
struct Seen {
  int keyframe = 0, old = 0;
  std::vector<LandmarkSight> sights;
};

std::vector<Seen> renumbered(const std::vector<LoopFit>& fits, const MergeOutcome& outcome) {
  std::vector<Seen> all;
  for (const LoopFit& fit : fits) {
    Seen seen{fit.newest, fit.old, fit.sights};
    if (outcome.into_kept) {
      seen.keyframe += outcome.appended.first_keyframe;
    } else {
      seen.old += outcome.appended.first_keyframe;
      for (LandmarkSight& s : seen.sights) s.track += outcome.appended.first_track;
    }
    all.push_back(std::move(seen));
  }
  return all;
}

// The keyframes of both maps that are near the place, as the merged map numbers them, by map.
struct Around {
  std::vector<int> here, there;
};

Around around(const Map& here, const Map& there, const LoopFit& fit, const MergeOutcome& outcome) {
  constexpr int kAsked = 24;  // of each map
  Around found{here.covisible(fit.newest, kAsked), there.covisible(fit.old, kAsked)};
  for (int k = here.num_keyframes() - 1, left = kAsked; k >= 0 && left > 0; --k, --left)
    if (!here.is_removed(k)) found.here.push_back(k);
  std::sort(found.here.begin(), found.here.end());
  found.here.erase(std::unique(found.here.begin(), found.here.end()), found.here.end());
  for (int& k : outcome.into_kept ? found.here : found.there) k += outcome.appended.first_keyframe;
  return found;
}

// Where two places have something in common alone, keyframes that look past it do not see what the
// other map has there.
Reason check_around(const Map& map, const Around& around, const SafeView& view,
                    const MapperOptions& options, MergeOutcome& outcome) {
  for (const bool of_here : {false, true}) {
    const std::vector<int> tracks = map.landmarks_of(of_here ? around.here : around.there);
    SeenAgain all;
    for (const int k : of_here ? around.there : around.here)
      all.add(seen_again(map, tracks, map.keyframe(k).observed(), map.pose(k), view, options));
    outcome.detail += "; around, " + all.in_words();
    if (!all.is_all_over(options.lost)) return Reason::kMergeUnlike;
  }
  return Reason::kNone;
}

// Joins what both see, and lets the filter find the mean.
bool join(Map& map, const std::vector<Seen>& all, const MapperOptions& options, int& joined) {
  std::vector<std::pair<std::vector<int>, std::vector<int>>> passes;
  for (const Seen& seen : all)
    passes.emplace_back(map.covisible(seen.keyframe, kAround), map.covisible(seen.old, kAround));
  for (const Seen& seen : all) joined += join_sights(map, seen.keyframe, seen.sights);
  if (!settle(map)) return false;
  joined += join_passes(map, passes.back().first, passes.back().second, options);
  return settle(map) && map.update().reason == Reason::kNone;
}

Reason check_left(const Map& map, const std::vector<Seen>& all, std::size_t sights_before,
                  MergeOutcome& outcome) {
  int left = 0, of = 0;
  for (const Seen& seen : all) {
    left += sights_left(map, seen.keyframe, seen.sights);
    of += static_cast<int>(seen.sights.size());
  }
  const auto sights = static_cast<double>(map.filter().num_measurements());
  const double share = sights / static_cast<double>(sights_before);
  outcome.detail += std::to_string(left) + " of " + std::to_string(of) +
                    " map features are left, and of all sights " + std::to_string(share);
  return 2 * left < of || share < kSightsLeft ? Reason::kLoopNotConfirmed : Reason::kNone;
}

Reason may_merge(const Map& into, const Map& other, const BoundOptions& bound) {
  if (other.is_measured()) return Reason::kMergeMeasured;
  const auto too_many = [](int a, int b, int most) { return most > 0 && a + b > most; };
  return too_many(into.num_keyframes_in_use(), other.num_keyframes_in_use(), bound.max_keyframes) ||
                 too_many(into.num_landmarks(), other.num_landmarks(), bound.max_landmarks)
             ? Reason::kMapFull
             : Reason::kNone;
}

Reason put_together(const Map& here, const Map& there, const std::vector<LoopFit>& fits,
                    const SafeView& view, const MapperOptions& options, MergeOutcome& outcome) {
  const Map& other = outcome.into_kept ? here : there;
  auto merged = std::make_shared<Map>(outcome.into_kept ? there : here);
  if (const Reason reason = may_merge(*merged, other, options.bound); reason != Reason::kNone)
    return reason;
  const Similarity kept_from_here = there_from_here(fits.back(), here);
  outcome.appended =
      merged->append(other, outcome.into_kept ? kept_from_here : kept_from_here.inverse());
  const std::size_t sights = merged->filter().num_measurements();
  const std::vector<Seen> all = renumbered(fits, outcome);
  if (!join(*merged, all, options, outcome.joined)) return Reason::kLoopNotConfirmed;
  if (const Reason reason = check_left(*merged, all, sights, outcome); reason != Reason::kNone)
    return reason;
  if (const Reason reason =
          check_around(*merged, around(here, there, fits.back(), outcome), view, options, outcome);
      reason != Reason::kNone)
    return reason;
  if (merged->is_measured()) judge_scale(*merged, options.measurement);
  outcome.merged = std::move(merged);
  return Reason::kNone;
}

}  // namespace

MergeOutcome merge_maps(const Map& here, std::int64_t map_id, int newest,
                        const std::vector<KeptView>& kept, const SafeView& view,
                        MergeSearch& search, const MapperOptions& options) {
  MergeOutcome outcome;
  MapsFit found = search.look(here, newest, kept, view, options);
  outcome.found = found.found;
  if (!found.found) return outcome;
  outcome.map_id = found.map_id;
  outcome.into_kept = found.map_id < map_id;
  outcome.reason = found.reason;
  outcome.detail = "map " + std::to_string(map_id) + " in map " + std::to_string(found.map_id) +
                   ", " + found.detail;
  search.begin_anew();
  if (!found.ok()) return outcome;
  const Map& there = *map_of(found.map_id, kept);
  LoopFit last = found.fits.back();
  std::vector<char> elsewhere;
  for (int k = 0; k < there.num_keyframes(); ++k) elsewhere.push_back(!there.is_removed(k));
  check_only_place(there, here.keyframe(newest).observed(), elsewhere, options, last);
  outcome.reason = last.reason;
  if (!last.ok()) {
    outcome.detail += last.detail;
    return outcome;
  }
  outcome.detail += "keyframe " + std::to_string(newest) + " at " + std::to_string(last.old) + ": ";
  outcome.reason = put_together(here, there, found.fits, view, options, outcome);
  return outcome;
}

}  // namespace eifmap
