#include "map/loop_closing.h"

#include <algorithm>
#include <utility>

#include "map/image_shift.h"
#include "map/loop_gate.h"
#include "map/loop_graph.h"
#include "map/loop_join.h"
#include "map/map_settling.h"
#include "map/pose_search.h"

namespace eifmap {
namespace {

constexpr int kAround = 12;  // keyframes of a pass whose landmarks are joined with the other's

// Whether the old place's landmarks are seen about where the map expects them.
bool agrees_already(const Map& map, const LoopFit& fit, const MapperOptions& options) {
  constexpr double kOfRadius = 0.5, kOfScale = 0.02;
  return median_shift(map, fit.sights, fit.world_from_newest.rigid(), map.pose(fit.newest)) <=
             kOfRadius * search_radius(map, options) &&
         std::abs(std::log(fit.world_from_newest.scale)) <= kOfScale;
}

Reason bend_and_join(Map& map, const LoopFit& fit, const MapperOptions& options,
                     LoopOutcome& outcome) {
  const std::vector<int> here = map.covisible(fit.newest, kAround);
  const std::vector<int> there = map.covisible(fit.old, kAround);
  if (!agrees_already(map, fit, options)) {
    PoseGraph graph = graph_with_loop(map, fit);
    if (!solve(graph).ok) return Reason::kLoopNotConfirmed;
    outcome.growth = map.bend(graph.nodes);
  }
  outcome.joined = join_sights(map, fit.newest, fit.sights);
  if (!settle(map)) return Reason::kLoopNotConfirmed;
  outcome.joined += join_passes(map, here, there, options);
  if (!settle(map)) return Reason::kLoopNotConfirmed;
  return map.update().reason == Reason::kNone ? Reason::kNone : Reason::kLoopNotConfirmed;
}

}  // namespace

LoopOutcome close_loop(Map& map, int newest, LoopSearch& search, const MapperOptions& options) {
  LoopOutcome outcome;
  outcome.newest = newest;
  const std::vector<int> places = likely_places(map, newest, search.turn(), options.loop);
  const std::optional<int> old = search.look(map, newest, places, options);
  if (!old) return outcome;
  outcome.found = true;
  outcome.old = *old;
  search.begin_anew();
  LoopFit fit = fit_loop(map, *old, newest, options);
  if (fit.ok()) check_possible(map, options.loop, fit);
  if (fit.ok()) check_only_place(map, options, fit);
  outcome.reason = fit.reason;
  outcome.detail = fit.detail;
  if (!fit.ok()) return outcome;
  Map closed = map;
  outcome.reason = bend_and_join(closed, fit, options, outcome);
  const int left = sights_left(closed, fit.newest, fit.sights);
  if (outcome.reason == Reason::kNone && 2 * left < static_cast<int>(fit.sights.size()))
    outcome.reason = Reason::kLoopNotConfirmed;
  outcome.detail = "keyframe " + std::to_string(newest) + " at " + std::to_string(*old) + ": " +
                   std::to_string(left) + " of " + std::to_string(fit.sights.size()) +
                   " map features are left in the map that was made of it";
  if (outcome.reason != Reason::kNone) {
    outcome.growth.clear();
    return outcome;
  }
  map = std::move(closed);
  return outcome;
}

}  // namespace eifmap
