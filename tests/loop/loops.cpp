// What closing loops makes of a run: errors against the truth with and without, loops closed and
// refused, and what it costs.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "consistency/frame_source.h"
#include "map/map_snapshot.h"
#include "mapper.h"
#include "sequence/trajectory_error.h"
#include "server/config.h"
#include "storage/map_file.h"
#include "support/thread_cpu.h"

namespace {

using namespace eifmap;
using namespace eifmap::test;

constexpr int kFailed = 1, kBadOptions = 2, kSkipped = 77;

struct Options {
  SourceOptions source;
  int seeds = 1, first_seed = 1;
  bool only_with = false;
  std::string config, map_file;
  int least_closed = 0, most_closed = 1000000;
  double ratio = 0;       // of errors, with over without; 0: any
  double end_ratio = 0;   // the same of the last frame's place, start to end
  double error = 0;       // m; 0: any
  double keyframe_s = 0;  // CPU time of the longest keyframe; 0: any
  double growth = -1;     // landmarks of the second half over those of the first; -1: any
  double tracked = 0;     // share of the frames
};

struct Outcome {
  double ate = 0, end = 0;            // m: all frames after alignment; the last frame, start to end
  double longest_keyframe = 0;        // CPU time, s
  MapperStatistics statistics, half;  // in the end, and after half of the frames

  // Of what is in the map, what the second half has added over what the first had.
  double keyframes_grown() const { return grown(half.keyframes, statistics.keyframes); }
  double landmarks_grown() const { return grown(half.landmarks, statistics.landmarks); }

 private:
  static double grown(std::int64_t before, std::int64_t now) {
    return before > 0 ? static_cast<double>(now - before) / static_cast<double>(before) : 0;
  }
};

MapperOptions mapper_options(const Options& options, bool with) {
  ServerConfig base;
  if (!options.config.empty()) {
    const ParsedConfig parsed = parse_config(options.config, base);
    const std::string problem = parsed.problem.empty() ? parsed.config.problem() : parsed.problem;
    if (!problem.empty()) throw std::invalid_argument("--config: " + problem);
    base = parsed.config;
  }
  base.mapper.loop.enabled = with;
  return base.mapper;
}

std::vector<TumPose> tum(const std::vector<TimedPose>& poses) {
  std::vector<TumPose> out;
  for (const TimedPose& p : poses)
    out.push_back({1e-6 * static_cast<double>(p.time_us), p.world_from_camera});
  return out;
}

// What the place of the last frame is off, seen from the first ones, whose gauge fixes the scale
// by the first tenth of the way.
double end_to_start(const std::vector<TimedPose>& truth, const std::vector<TimedPose>& estimate) {
  const auto n = static_cast<Eigen::Index>(std::max<std::size_t>(3, estimate.size() / 10));
  if (estimate.size() < 4 || estimate.size() > truth.size()) return 0;
  Eigen::Matrix3Xd a(3, n), b(3, n);
  const auto true_at = [&](std::int64_t time_us) {
    for (const TimedPose& p : truth)
      if (p.time_us == time_us) return p.world_from_camera.translation;
    return Eigen::Vector3d(Eigen::Vector3d::Zero());
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const TimedPose& p = estimate[static_cast<std::size_t>(k)];
    a.col(k) = true_at(p.time_us);
    b.col(k) = p.world_from_camera.translation;
  }
  const Similarity truth_from_map = fit_similarity(a, b);
  const TimedPose& last = estimate.back();
  return (true_at(last.time_us) - truth_from_map * last.world_from_camera.translation).norm();
}

// CPU time of keyframes, s.
class KeyframeTimes {
 public:
  void operator()(std::string_view step, bool begins) {
    if (step != "keyframe") return;
    if (begins)
      begin_ = thread_cpu_seconds();
    else
      longest_ = std::max(longest_, thread_cpu_seconds() - begin_);
  }
  double longest() const { return longest_; }

 private:
  double begin_ = 0, longest_ = 0;
};

// What became of each loop, as it is said; and where the camera was lost.
class Diary {
 public:
  void add(int frame, const FrameResult& result, const MapperStatistics& statistics) {
    const LoopCounts& loops = statistics.loops;
    if (loops.closed + loops.joined > closed_)
      std::printf("  frame %d: %s: %s\n", frame, loops.closed > bent_ ? "closed" : "joined",
                  loops.last.c_str());
    closed_ = loops.closed + loops.joined;
    bent_ = loops.closed;
    const bool lost = result.state == TrackingState::kLost;
    if (lost && !lost_)
      std::printf("  frame %d: lost: %s %s\n", frame, describe(result.reason).name,
                  result.detail.c_str());
    lost_ = lost;
  }

 private:
  std::int64_t closed_ = 0, bent_ = 0;
  bool lost_ = false;
};

void print(const Outcome& outcome, int seed, bool with, double cpu_s, double longest_s) {
  const MapperStatistics& s = outcome.statistics;
  std::printf(
      "seed %d %s: ATE %.4f m, end %.4f m; tracked %d of %d, %d losses, %d keyframes, %.1f s, "
      "longest keyframe %.2f s; loops closed %d, joined %d",
      seed, with ? "with" : "without", outcome.ate, outcome.end, static_cast<int>(s.tracked),
      static_cast<int>(s.frames), static_cast<int>(s.losses), static_cast<int>(s.keyframes), cpu_s,
      longest_s, static_cast<int>(s.loops.closed), static_cast<int>(s.loops.joined));
  for (const auto& [reason, count] : s.loops.refused)
    std::printf(", %s %d", describe(reason).name, static_cast<int>(count));
  std::printf("; %d keyframes and %d landmarks after half, %+.0f %% and %+.0f %% since",
              static_cast<int>(outcome.half.keyframes), static_cast<int>(outcome.half.landmarks),
              100 * outcome.keyframes_grown(), 100 * outcome.landmarks_grown());
  std::printf("%s%s\n", s.loops.last.empty() ? "" : "; last: ", s.loops.last.c_str());
  std::fflush(stdout);
}

// What it costs to keep the map in a file, and to have it back.
class Kept {
 public:
  explicit Kept(const std::string& file) : path_(file), file_(file) {}
  void save(const Mapper& mapper, const Camera& camera) {
    if (path_.empty()) return;
    const double before = thread_cpu_seconds();
    const MapperSnapshot snapshot = mapper.snapshot();
    const std::string problem = file_.save(*snapshot.in_use, {camera, 0, 1, {}});
    if (!problem.empty()) std::printf("FAILED: %s\n", problem.c_str());
    ms_.push_back(1e3 * (thread_cpu_seconds() - before));
  }
  void say(const MapperOptions& options) {
    if (ms_.empty()) return;
    const double before = thread_cpu_seconds();
    const LoadedMap loaded = load_map(path_, options);
    const double load_s = thread_cpu_seconds() - before;
    if (!loaded.ok()) return static_cast<void>(std::printf("FAILED: %s\n", loaded.detail.c_str()));
    Mapper again(loaded.head.names.camera, options);
    again.restore({loaded.snapshot, {}, 1, 0});
    again.map_update();
    const double whole_s = thread_cpu_seconds() - before;
    std::sort(ms_.begin(), ms_.end());
    std::printf(
        "  kept: %zu updates in %.1f MB, CPU of one %.1f ms in the median, %.1f at most; loaded in "
        "%.2f s CPU, with all covariances to be published %.2f s: %d keyframes, %d landmarks, %zu "
        "observations\n",
        ms_.size(), 1e-6 * static_cast<double>(file_.size()), ms_[ms_.size() / 2], ms_.back(),
        load_s, whole_s, loaded.snapshot.map->num_keyframes_in_use(),
        loaded.snapshot.map->num_landmarks(), loaded.snapshot.map->filter().num_measurements());
  }

 private:
  std::string path_;
  MapFile file_;
  std::vector<double> ms_;
};

Outcome run_once(const Options& options, const FrameSource& source, int seed, bool with) {
  Mapper mapper(source.camera(), mapper_options(options, with));
  KeyframeTimes times;
  mapper.set_step_observer([&times](std::string_view step, bool begins) { times(step, begins); });
  std::vector<TimedPose> truth;
  Outcome outcome;
  Diary diary;
  Kept kept(with ? options.map_file : "");
  double cpu_s = 0;
  for (int i = 0; i < source.size(); ++i) {
    if (const auto pose = source.world_from_camera(i)) truth.push_back({source.time_us(i), *pose});
    const FeatureFrame frame = source.frame(i);
    const double before = thread_cpu_seconds();
    const FrameResult result = mapper.process(frame);
    cpu_s += thread_cpu_seconds() - before;
    diary.add(i, result, mapper.statistics());
    if (result.map_updated) kept.save(mapper, source.camera());
    if (i == source.size() / 2) outcome.half = mapper.statistics();
  }
  const std::vector<TimedPose> estimate = mapper.final_trajectory();
  const TrajectoryError error = trajectory_error(tum(truth), tum(estimate), {});
  outcome.ate = error.aligned ? error.rmse_m : -1;
  outcome.end = end_to_start(truth, estimate);
  outcome.longest_keyframe = times.longest();
  outcome.statistics = mapper.statistics();
  for (const std::string& problem : mapper.audit()) std::printf("FAILED: %s\n", problem.c_str());
  print(outcome, seed, with, cpu_s, times.longest());
  kept.say(mapper_options(options, with));
  return outcome;
}

bool expect(bool holds, const char* otherwise, double limit) {
  if (!holds) std::printf("FAILED: %s %.3f\n", otherwise, limit);
  return holds;
}

bool expect_of_loops(const Options& options, const Outcome& with, const Outcome& without) {
  const auto closed = static_cast<int>(with.statistics.loops.closed + with.statistics.loops.joined);
  bool good = closed >= options.least_closed && closed <= options.most_closed;
  if (!good) std::printf("FAILED: %d loops closed\n", closed);
  if (options.ratio > 0)
    good = expect(with.ate <= options.ratio * without.ate, "the error over that without is above",
                  options.ratio) &&
           good;
  if (options.end_ratio > 0)
    good = expect(with.end <= options.end_ratio * without.end,
                  "the end's error over that without is above", options.end_ratio) &&
           good;
  return good;
}

bool expect_of_run(const Options& options, const Outcome& with) {
  const MapperStatistics& s = with.statistics;
  bool good =
      expect(static_cast<double>(s.tracked) >= options.tracked * static_cast<double>(s.frames),
             "the share of frames tracked is below", options.tracked);
  if (options.error > 0)
    good = expect(with.ate <= options.error, "the error (m) is above", options.error) && good;
  if (options.keyframe_s > 0)
    good = expect(with.longest_keyframe <= options.keyframe_s,
                  "the CPU time (s) of a keyframe is above", options.keyframe_s) &&
           good;
  if (options.growth >= 0)
    good = expect(with.landmarks_grown() <= options.growth,
                  "the landmarks that the second half adds, over those of the first, are above",
                  options.growth) &&
           good;
  return good;
}

bool judge(const Options& options, int seed) {
  auto source = make_source(options.source, seed);
  const Outcome without = options.only_with ? Outcome() : run_once(options, *source, seed, false);
  if (!options.only_with && !source->goes_again()) source = make_source(options.source, seed);
  const Outcome with = run_once(options, *source, seed, true);
  const bool good = expect_of_loops(options, with, without);
  return expect_of_run(options, with) && good;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  Options options;
  CLI::App app("What closing loops makes of a run", "loops");
  app.add_option("world", options.source.world,
                 "sideways, forward, loop, street, corridor: features only; lap, tiles, block, "
                 "rendered_corridor: rendered; a file of poses (.txt): features along that way; "
                 "or a recorded folder");
  app.add_option("--event", options.source.event, "rendered only: what happens on the way");
  app.add_option("--seeds", options.seeds, "runs");
  app.add_option("--first-seed", options.first_seed, "of the first run");
  app.add_option("--frames", options.source.frames, "of each run; 0: all");
  app.add_option("--noise-px", options.source.noise_px, "features only: the noise");
  app.add_option("--cache", options.source.cache, "folder that keeps the rendered images");
  app.add_option("--map-file", options.map_file,
                 "keep the map in this file by each update, and say what that costs");
  app.add_flag("--only-with", options.only_with, "no run without, to compare with");
  app.add_option("--config", options.config, "JSON as in the server's file; of it, the mapper");
  app.add_option("--least", options.least_closed, "expected: loops closed, at least");
  app.add_option("--most", options.most_closed, "expected: loops closed, at most");
  app.add_option("--ratio", options.ratio, "expected: error with over error without, at most");
  app.add_option("--end-ratio", options.end_ratio, "the same of the last frame's place");
  app.add_option("--error", options.error, "expected: error with, at most (m)");
  app.add_option("--keyframe-s", options.keyframe_s,
                 "expected: CPU time of the longest keyframe with, at most (s)");
  app.add_option("--growth", options.growth,
                 "expected: landmarks that the second half adds over those of the first, at most");
  app.add_option("--tracked", options.tracked, "expected: share of frames tracked with, at least");
  CLI11_PARSE(app, argc, argv);
  try {
    const std::string& world = options.source.world;
    if (world.find('/') != std::string::npos && !std::filesystem::exists(world)) {
      std::printf("skipped: no %s\n", world.c_str());
      return kSkipped;
    }
    bool good = true;
    for (int i = 0; i < options.seeds; ++i) good = judge(options, options.first_seed + i) && good;
    return good ? 0 : kFailed;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "loops: %s\n", error.what());
    return kBadOptions;
  }
}
