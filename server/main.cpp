// eifmap-server: options in, exit code out.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <fstream>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "bus/lcm_bus.h"
#include "bus/stop_signals.h"
#include "program/command_line.h"
#include "program/progress_bar.h"
#include "sequence/camera_file.h"
#include "server/mapping_server.h"
#include "server/run_record.h"
#include "server/sequence_run.h"

namespace {

using namespace eifmap;

constexpr int kFailed = 1;
constexpr int kBadOptions = 2;

// Groups of options.
constexpr const char* kLive = "Live, over LCM";
constexpr const char* kRecorded = "Recorded, without a network";

struct Options {
  std::string config_file, lcm_url, camera, input, secret_file;
  bool print_config = false, paper = false;
  SequenceRunOptions sequence;
};

std::string read_file(const std::string& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) throw std::invalid_argument(file + ": cannot be read");
  return text.str();
}

// The preset's values, then the file's, then the command line's.
ServerConfig effective_config(const Options& options) {
  ParsedConfig parsed;
  if (options.paper) parsed.config.mapper = MapperOptions::paper();
  if (!options.config_file.empty()) {
    parsed = parse_config(read_file(options.config_file), parsed.config);
    if (!parsed.problem.empty())
      throw std::invalid_argument(options.config_file + ": " + parsed.problem);
  }
  ServerConfig& config = parsed.config;
  if (!options.lcm_url.empty()) config.lcm_url = options.lcm_url;
  if (!options.camera.empty()) config.camera = options.camera;
  if (!options.secret_file.empty()) config.secret_file = options.secret_file;
  if (!options.input.empty())
    config.input = options.input == "lossless" ? InputMode::kLossless : InputMode::kNewest;
  const auto& calibration_file = options.sequence.images.calibration;
  if (options.sequence.sequence.empty() && !calibration_file.empty()) {
    const CameraFile calibration = read_camera(calibration_file);
    if (!calibration.problem.empty()) throw std::invalid_argument(calibration.problem);
    config.calibration = calibration.camera;
  }
  if (options.sequence.images.hfov_deg != 0) config.hfov_deg = options.sequence.images.hfov_deg;
  if (const std::string problem = config.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  return config;
}

int run_recorded(SequenceRunOptions options, const ServerConfig& config, StopSignals& signals) {
  if (options.output.empty())
    throw std::invalid_argument(
        "--sequence needs --output FOLDER, for trajectories, map and report");
  options.features = config.features;
  options.mapper = config.mapper;
  options.handover = config.recorded_handover();
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  bool interrupted = false;
  const auto progress = [&](int done, int total) {
    bar.show(done, total);
    interrupted = interrupted || (done != total && signals.arrived());
    return !interrupted;
  };
  const std::string problem =
      run_sequence(options, progress, [](const std::string& note) { spdlog::warn(note); });
  if (!problem.empty()) {
    spdlog::error(problem);
    return kFailed;
  }
  if (interrupted)
    spdlog::warn("interrupted: the results in {} are partial", options.output.string());
  else
    spdlog::info("results are in {}", options.output.string());
  return 0;
}

void log_change(const status_t& status) {
  const auto level = status.level == status_t::LEVEL_OK        ? spdlog::level::info
                     : status.level == status_t::LEVEL_WARNING ? spdlog::level::warn
                                                               : spdlog::level::err;
  static constexpr const char* kStates[] = {"waiting", "starting", "tracking",
                                            "lost",    "paused",   "stopping"};
  spdlog::log(level, "{}{}{}: {}{}{}", status.camera, status.camera.empty() ? "" : ": ",
              kStates[status.state], status.message, status.hint.empty() ? "" : "; ", status.hint);
}

int run_live(const ServerConfig& config, const std::filesystem::path& output,
             StopSignals& signals) {
  if (!output.empty())
    if (const std::string problem = output_problem(output); !problem.empty()) {
      spdlog::error(problem);
      return kFailed;
    }
  const LcmBus::Opened opened = LcmBus::open(config.lcm_url);
  if (!opened.problem.empty()) {
    spdlog::error(opened.problem);
    return kFailed;
  }
  if (!opened.advice.empty()) spdlog::warn(opened.advice);
  MappingServer server(config, *opened.bus, log_change);
  spdlog::info("listening on {}", config.lcm_url);
  bool healthy = true;
  while (healthy && !signals.arrived() && !server.told_to_stop())
    healthy = opened.bus->receive(std::chrono::milliseconds(100));
  if (!healthy) spdlog::error("LCM broke off at {}", config.lcm_url);
  if (server.told_to_stop()) spdlog::info("shut down by command");
  server.stop();
  spdlog::info("stopped");
  if (output.empty()) return healthy ? 0 : kFailed;
  if (!server.has_results()) {
    spdlog::warn("no calibrated frame has arrived: nothing is written to {}", output.string());
    return healthy ? 0 : kFailed;
  }
  const std::string problem = server.write_results(output);
  if (!problem.empty()) spdlog::error(problem);
  return healthy && problem.empty() ? 0 : kFailed;
}

int run(const Options& options, StopSignals& signals) {
  try {
    const ServerConfig config = effective_config(options);
    if (options.print_config) {
      std::cout << config_text(config) << '\n';
      return 0;
    }
    if (!options.sequence.sequence.empty()) return run_recorded(options.sequence, config, signals);
    return run_live(config, options.sequence.output, signals);
  } catch (const std::invalid_argument& error) {
    spdlog::error(error.what());
    return kBadOptions;
  } catch (const std::exception& error) {
    spdlog::error(error.what());
    return kFailed;
  }
}

void add_options(CLI::App& app, Options& options) {
  SequenceRunOptions& sequence = options.sequence;
  app.set_version_flag("--version", EIFMAP_VERSION);
  app.add_option("--config", options.config_file, "JSON file; --print-config shows every key");
  app.add_flag("--print-config", options.print_config, "print the configuration in force and stop");
  app.add_flag(
      "--paper", options.paper,
      "the published method to the letter (Wang & Dissanayake 2010); the configuration file "
      "still changes it");
  add_calibration_options(app, sequence.images);
  app.add_option("--output", sequence.output, "folder for trajectories, map and report");

  app.add_option("--lcm-url", options.lcm_url, "network to listen and publish on")->group(kLive);
  app.add_option("--camera", options.camera,
                 "the only camera to map; default: every one that is heard, up to max_cameras")
      ->group(kLive);
  app.add_option("--input", options.input, "newest: keep up; lossless: take every frame")
      ->check(one_of(std::vector<std::string>{"newest", "lossless"}))
      ->group(kLive);
  app.add_option("--secret-file", options.secret_file,
                 "who may command: who signs with what this file holds (eifmap ctl)")
      ->group(kLive);

  app.add_option(
         "--sequence", sequence.sequence,
         "a folder of images (eifmap, KITTI odometry, TUM RGB-D, EuRoC MAV, or images alone), "
         "or a video")
      ->group(kRecorded);
  app.add_option("--rate", sequence.images.rate_hz, "of images that have no times, a second")
      ->check(number_in(0.001, 10000))
      ->group(kRecorded);
  app.add_option("--every", sequence.every, "take every n-th image")
      ->check(number_in(1))
      ->group(kRecorded);
  app.add_option("--max-frames", sequence.max_frames, "stop after so many of them; 0: all")
      ->check(number_in(0))
      ->group(kRecorded);
  app.add_option("--jitter-px", sequence.jitter_px, "noise added to the features' places, px")
      ->check(number_in(0))
      ->group(kRecorded);
  app.add_option("--decisions", sequence.decisions,
                 "decisions.jsonl of a live run of these images: decide as it did")
      ->group(kRecorded);
  app.add_option("--measurements", sequence.measurements,
                 "absolute measurements, a JSON object a line, that fix the map's scale")
      ->group(kRecorded);
  app.add_option("--seed", sequence.seed, "of that noise")->group(kRecorded);
}

// Options of one way to run with the other one.
std::string mixed_options(const CLI::App& app) {
  const bool recorded = app.get_option("--sequence")->count() > 0;
  if (app.get_option("--decisions")->count() > 0)
    for (const char* option : {"--every", "--max-frames", "--jitter-px"})
      if (app.get_option(option)->count() > 0)
        return std::string(option) + " is of another run than the one in --decisions: leave it out";
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    if (recorded && option->get_group() == kLive)
      return option->get_name() +
             " is of a live server, and --sequence maps without a network: "
             "leave one of them out";
    if (!recorded && option->get_group() == kRecorded)
      return option->get_name() +
             " is of recorded images: give them by --sequence, or leave it out";
  }
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  StopSignals signals;
  cv::setNumThreads(1);  // one mapping thread is the whole plan; results must not depend on cores
  spdlog::set_default_logger(spdlog::stderr_color_mt("eifmap-server"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  Options options;
  CLI::App app("Maps cameras' images: publishes each one's poses and map of points.",
               "eifmap-server");
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string problem = explain(app, error);
    if (problem.empty()) return 0;
    spdlog::error(problem);
    return kBadOptions;
  }
  if (const std::string problem = mixed_options(app); !problem.empty()) {
    spdlog::error(problem);
    return kBadOptions;
  }
  return run(options, signals);
}
