// A fast turn past near things: the map after it has the scale that it had before, or it is another
// map and LOST was said.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <opencv2/core/utility.hpp>

#include "consistency/judgement.h"
#include "simulation/walk.h"

namespace {

using namespace eifmap;
using namespace eifmap::test;

constexpr double kAllowed = 0.05;
constexpr int kFailed = 1, kBadOptions = 2;

bool tracked_in(std::int64_t map, const FrameResult& result) {
  return result.state == TrackingState::kTracking && result.map_id == map;
}

// Ratio of the way in the map to the true one over frames [first, last], as the crow flies in steps
// of ten frames: a step's own error is small against it. 0 when the map has no such step.
double scale_between(const FrameSource& source, const JudgedRun& run, std::int64_t map, int first,
                     int last) {
  constexpr int kStep = 10;
  double in_map = 0, truth = 0;
  for (int i = first; i + kStep <= last; i += kStep) {
    const FrameResult &a = run.results[static_cast<std::size_t>(i)],
                      &b = run.results[static_cast<std::size_t>(i + kStep)];
    const auto true_a = source.world_from_camera(i), true_b = source.world_from_camera(i + kStep);
    if (!tracked_in(map, a) || !tracked_in(map, b) || !true_a || !true_b) continue;
    in_map += (a.map_from_camera.translation - b.map_from_camera.translation).norm();
    truth += (true_a->translation - true_b->translation).norm();
  }
  return truth > 0 ? in_map / truth : 0;
}

bool lost_between(const JudgedRun& run, int first, int last) {
  for (int i = first; i <= last; ++i)
    if (run.results[static_cast<std::size_t>(i)].state == TrackingState::kLost) return true;
  return false;
}

// The last map that was tracked in within frames [first, last]; 0 none.
std::int64_t map_in(const JudgedRun& run, int first, int last) {
  std::int64_t map = 0;
  for (int i = first; i <= last; ++i) {
    const FrameResult& result = run.results[static_cast<std::size_t>(i)];
    if (result.state == TrackingState::kTracking) map = result.map_id;
  }
  return map;
}

bool judge_turn(int seed, int frames) {
  SourceOptions options;
  options.world = "turn";
  options.frames = frames;
  const auto source = make_source(options, seed);
  const JudgedRun run = judge_run(*source, MapperOptions());
  simulation::Walk walk;
  walk.path = simulation::Path::kRectangle;
  const simulation::TurnTimes turn = simulation::first_turn(walk);
  const auto frame_at = [&](double seconds) {
    int i = 0;
    while (i + 1 < source->size() &&
           1e-6 * static_cast<double>(source->time_us(i) - source->time_us(0)) < seconds)
      ++i;
    return i;
  };
  const int begin = frame_at(turn.begin), end = frame_at(turn.end), last = source->size() - 1;
  const std::int64_t map_before = map_in(run, 0, begin), map_after = map_in(run, end, last);
  const double before = scale_between(*source, run, map_before, 0, begin);
  const double after = scale_between(*source, run, map_after, end, last);
  const bool said = lost_between(run, begin, last), same_map = map_before == map_after;
  const bool kept = before > 0 && after > 0 && std::abs(after / before - 1) <= kAllowed;
  const bool good = before > 0 && (same_map ? kept || after == 0 : said);
  std::printf(
      "seed %d: scale before %.3f, after %.3f, %s%s\n", seed, before, after,
      said ? (same_map ? "LOST was said" : "LOST was said, and a new map begun") : "never lost",
      good ? "" : "  FAILED");
  std::fflush(stdout);
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  int seeds = 20, frames = 160;
  CLI::App app("Scale of the map before and after a fast turn", "scale_jump");
  app.add_option("--seeds", seeds, "runs");
  app.add_option("--frames", frames, "of each run");
  CLI11_PARSE(app, argc, argv);
  try {
    bool good = true;
    for (int seed = 1; seed <= seeds; ++seed) good = judge_turn(seed, frames) && good;
    return good ? 0 : kFailed;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scale_jump: %s\n", error.what());
    return kBadOptions;
  }
}
