// Whether the errors of many runs are as large as their covariances say.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "consistency/band.h"
#include "consistency/judgement.h"
#include "consistency/measurements.h"
#include "server/config.h"

namespace {

using namespace eifmap;
using namespace eifmap::test;

constexpr int kFailed = 1, kBadOptions = 2, kSkipped = 77;

struct Options {
  SourceOptions source;
  MeasurementSource measurements;
  int seeds = 30, first_seed = 1;
  bool paper = false;
  std::string config;  // JSON as in the server's file
  std::array<double, 2> keyframes{0, 1e9}, final{0, 1e9};
  double within = 0;
  std::vector<std::string> bands;  // beginnings of statistics' names
  bool show_scale = false;
  bool no_alarm = false;  // of the sigmas
  int alarm_by = 0;       // keyframes in the map; 0: need not be
  std::string json;
};

// Sums over the runs.
struct Totals {
  int runs = 0;
  double keyframes = 0, published = 0, final = 0, within = 0, scale_squared = 0;
  double nis = 0;  // of sights
  std::vector<RunStatistic> statistics;

  void add(const char* name, int degrees, double value) {
    for (RunStatistic& s : statistics)
      if (s.name == name) return s.of_runs.push_back(value);
    statistics.push_back({name, degrees, {value}});
  }
  void add(const char* name, int degrees, const std::vector<double>& values) {
    if (!values.empty())
      add(name, degrees,
          std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()));
  }
};

// Error along the way from the first keyframe, where an error of the scale shows, in sigmas.
double error_along(const JudgedPose& pose) {
  const Eigen::Vector3d u = pose.truth.normalized();
  return u.dot(pose.error.head<3>()) / std::sqrt(u.dot(pose.covariance.topLeftCorner<3, 3>() * u));
}

double nis_ratio(const JudgedRun& run, InnovationKind kind) {
  const auto of_kind = run.statistics.nis.find(kind);
  return of_kind == run.statistics.nis.end() ? 0 : of_kind->second.ratio;
}

std::string said_of(const JudgedRun& run) {
  return run.first_alarm == 0 ? "no alarm"
                              : "an alarm at keyframe " + std::to_string(run.first_alarm);
}

MapperOptions mapper_options(const Options& options) {
  ServerConfig base;
  const std::string& world = options.source.world;
  if (options.source.calibration_off == 0 && world.find('/') == std::string::npos)
    base.mapper.measurement.focal_sigma = base.mapper.measurement.centre_sigma_px =
        base.mapper.measurement.radial_sigma = 0;
  if (options.paper) base.mapper = MapperOptions::paper();
  if (options.config.empty()) return base.mapper;
  const ParsedConfig parsed = parse_config(options.config, base);
  const std::string problem = parsed.problem.empty() ? parsed.config.problem() : parsed.problem;
  if (!problem.empty()) throw std::invalid_argument("--config: " + problem);
  return parsed.config.mapper;
}

// What is to be in its 95 % band.
void add_statistics(const Options& options, const JudgedRun& run, Totals& totals) {
  totals.add("pose, all keyframes", 6, *mean_nees(run.keyframes));
  totals.add("pose, last keyframe", 6, run.keyframes.back().nees);
  totals.add("pose, last frame", 6, run.published.back().nees);
  totals.add("keyframes to each other", 6, run.relative);
  totals.add("landmarks", 3, run.landmarks);
  totals.add("along the way", 1, std::pow(error_along(run.keyframes.back()), 2));
  totals.add("keyframes in earth", 6, run.earth_keyframes);
  totals.add("landmarks in earth", 3, run.earth_landmarks);
  if (run.scale_of_all)
    totals.add("log scale of the map", 1, std::pow(run.scale_of_all->in_sigmas(), 2));
  if (run.scale_newest.empty()) return;
  const JudgedRun::ScaleError &first = run.scale_newest.front(), &last = run.scale_newest.back();
  totals.add("log scale, newest, when fixed", 1, std::pow(first.in_sigmas(), 2));
  totals.add("log scale, newest, at the end", 1, std::pow(last.in_sigmas(), 2));
  std::printf(
      "  log scale at the newest keyframes: sigma %.4f when fixed, %.4f at the end, %+.4f off\n",
      first.sigma, last.sigma, last.error);
  if (!options.show_scale) return;
  for (const JudgedRun::ScaleError& e : run.scale_newest)
    std::printf("    at %.1f s: %+.4f off, sigma %.4f, %+.1f sigma\n",
                1e-6 * static_cast<double>(e.time_us), e.error, e.sigma, e.in_sigmas());
}

bool show_statistics(const Totals& totals, const std::vector<std::string>& judged) {
  bool good = true;
  for (const RunStatistic& s : totals.statistics) {
    if (s.of_runs.size() < 2) continue;
    const bool wanted = std::any_of(judged.begin(), judged.end(), [&s](const std::string& name) {
      return s.name.starts_with(name);
    });
    const char* verdict = s.in_band() ? "" : wanted ? "  FAILED: not in it" : "  not in it";
    std::printf("NEES of %-30s %6.2f, 95 %% band %.2f to %.2f; %+.1f sigma of runs from %d%s\n",
                (s.name + ":").c_str(), s.mean(), s.band()[0], s.band()[1], s.deviation(),
                s.degrees, verdict);
    good = good && (s.in_band() || !wanted);
  }
  for (const std::string& name : judged)
    if (std::none_of(totals.statistics.begin(), totals.statistics.end(),
                     [&name](const RunStatistic& s) { return s.name.starts_with(name); })) {
      std::printf("FAILED: nothing was judged of %s\n", name.c_str());
      good = false;
    }
  return good;
}

bool add_run(const Options& options, int seed, Totals& totals) {
  const auto source = make_source(options.source, seed);
  const JudgedRun run =
      judge_run(*source, mapper_options(options), 1,
                make_measurements(*source, options.measurements, seed), earth_from_world(seed));
  if (run.keyframes.empty() || run.published.empty()) {
    std::printf("seed %d: no map with covariances\n", seed);
    return false;
  }
  const double keyframes = *mean_nees(run.keyframes), published = *mean_nees(run.published);
  const double final = run.published.back().nees, within = share_within_three_sigma(run.published);
  const double along = error_along(run.keyframes.back());
  const double sights = nis_ratio(run, InnovationKind::kSight);
  const double edges = nis_ratio(run, InnovationKind::kEdge);
  std::printf(
      "seed %d: tracked %d of %d, %d losses, NEES of keyframes %.2f, of frames %.2f, of the "
      "last frame %.2f, within 3 sigma %.3f, along the way %+.2f sigma; NIS of sights %.2f, of "
      "edges %.2f, %s\n",
      seed, run.tracked, run.frames, static_cast<int>(run.statistics.losses), keyframes, published,
      final, within, along, sights, edges, said_of(run).c_str());
  if (run.statistics.losses > 0)
    for (const auto& [reason, frames] : run.statistics.reasons)
      std::printf("  %s: %d frames\n", describe(reason).name, static_cast<int>(frames));
  std::fflush(stdout);
  add_statistics(options, run, totals);
  ++totals.runs;
  totals.keyframes += keyframes;
  totals.published += published;
  totals.final += final;
  totals.within += within;
  totals.scale_squared += along * along;
  totals.nis += sights;
  const bool alarmed = run.first_alarm > 0 && run.first_alarm <= options.alarm_by;
  if (options.alarm_by > 0 && !alarmed) std::printf("FAILED: no alarm by then\n");
  if (options.no_alarm && run.first_alarm > 0) std::printf("FAILED: an alarm\n");
  return !(options.alarm_by > 0 && !alarmed) && !(options.no_alarm && run.first_alarm > 0);
}

bool inside(const char* what, double value, const std::array<double, 2>& range) {
  if (value >= range[0] && value <= range[1]) return true;
  std::printf("FAILED: %s is %.2f, wanted %.2f to %.2f\n", what, value, range[0], range[1]);
  return false;
}

bool write_json(const Options& options, const Totals& totals) {
  const double n = totals.runs;
  const nlohmann::ordered_json json = {
      {"world", options.source.world},
      {"paper", options.paper},
      {"runs", totals.runs},
      {"nees_keyframes", totals.keyframes / n},
      {"nees_frames", totals.published / n},
      {"nees_last_frame", totals.final / n},
      {"within_three_sigma", totals.within / n},
      {"nis_sights", totals.nis / n},
      {"along_the_way_rms_sigma", std::sqrt(totals.scale_squared / n)}};
  std::ofstream out(options.json);
  out << json.dump(2) << '\n';
  if (out) return true;
  std::fprintf(stderr, "consistency: cannot write %s\n", options.json.c_str());
  return false;
}

int run(const Options& options) {
  Totals totals;
  bool good = true;
  for (int i = 0; i < options.seeds; ++i)
    good = add_run(options, options.first_seed + i, totals) && good;
  if (totals.runs == 0) return kFailed;
  const double n = totals.runs;
  std::printf(
      "%s, mean of %d: NEES of keyframes %.2f, of frames %.2f, of the last frame %.2f, "
      "within 3 sigma %.3f, along the way rms %.2f sigma; NIS of sights %.2f\n",
      options.source.world.c_str(), totals.runs, totals.keyframes / n, totals.published / n,
      totals.final / n, totals.within / n, std::sqrt(totals.scale_squared / n), totals.nis / n);
  good = show_statistics(totals, options.bands) && good;
  good = inside("the mean NEES of keyframes", totals.keyframes / n, options.keyframes) && good;
  good = inside("the mean NEES of the last frame", totals.final / n, options.final) && good;
  good = inside("the share within 3 sigma", totals.within / n, {options.within, 1}) && good;
  if (!options.json.empty()) good = write_json(options, totals) && good;
  return good ? 0 : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  Options options;
  CLI::App app("Errors of many runs against their covariances (NEES; 6 is right)", "consistency");
  app.add_option(
      "world", options.source.world,
      "sideways, forward, loop: features only; lap, turn, block: rendered; or a recorded folder");
  app.add_option("--seeds", options.seeds, "runs");
  app.add_option("--first-seed", options.first_seed, "of the first run");
  app.add_option("--frames", options.source.frames, "of each run; 0: all");
  app.add_option("--drift-px", options.source.drift_px,
                 "features only: how far a point's place drifts with the viewing direction");
  app.add_option("--noise-ratio", options.source.noise_ratio,
                 "features only: the noise over what the keypoints claim of it");
  app.add_option("--noise-px", options.source.noise_px, "features only: the noise");
  app.add_option("--cache", options.source.cache,
                 "folder that keeps the rendered images; empty it when the simulation changes");
  app.add_option("--json", options.json, "file for the means");
  app.add_flag("--paper", options.paper, "the published method to the letter");
  app.add_option("--config", options.config, "JSON as in the server's file; of it, the mapper");
  app.add_option("--keyframes", options.keyframes, "expected mean NEES of keyframes: from, to");
  app.add_option("--last", options.final, "expected mean NEES of the last frame: from, to");
  app.add_option(
      "--calibration-off", options.source.calibration_off,
      "features only: the calibration's errors, in sigmas; 0: neither errors nor sigmas");
  app.add_option("--gps", options.measurements.gps_sigma,
                 "positions are measured, with so much noise (m, each axis)");
  app.add_option("--gps-every", options.measurements.gps_every, "frames from one to the next");
  app.add_option("--distance", options.measurements.distance_sigma,
                 "one distance on the first third is measured, with so much noise (of it)");
  app.add_option("--distance-from", options.measurements.distance_from, "share of the frames");
  app.add_option("--distance-to", options.measurements.distance_to, "share of the frames");
  app.add_flag("--show-scale", options.show_scale, "the scale's error keyframe by keyframe");
  app.add_option("--bands", options.bands,
                 "NEES that must be in their 95 % bands, by how their names begin");
  app.add_flag("--no-alarm", options.no_alarm, "no run may find its sigmas suspect");
  app.add_option("--alarm-by", options.alarm_by,
                 "each run must find its sigmas suspect by so many keyframes");
  app.add_option("--within", options.within, "expected least share within 3 sigma");
  CLI11_PARSE(app, argc, argv);
  try {
    const std::string& world = options.source.world;
    if (world.find('/') != std::string::npos && !std::filesystem::is_directory(world)) {
      std::printf("skipped: no %s\n", world.c_str());
      return kSkipped;
    }
    return run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "consistency: %s\n", error.what());
    return kBadOptions;
  }
}
