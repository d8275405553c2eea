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
#include "server/check_map.h"
#include "server/log_run.h"
#include "server/mapping_server.h"
#include "server/metrics_server.h"
#include "server/metrics_text.h"
#include "server/run_record.h"
#include "server/sequence_run.h"

namespace {

using namespace eifmap;

constexpr int kFailed = 1;
constexpr int kBadOptions = 2;

// Groups of options.
constexpr const char* kLive = "Live, over LCM";
constexpr const char* kRecorded = "Recorded, without a network";
constexpr const char* kLogged = "Of an LCM event log, without a network";

struct Options {
  std::string config_file, lcm_url, camera, input, maps_folder, secret_file;
  std::filesystem::path check_map;
  bool localize_only = false, repair = false;
  std::optional<int> metrics_port;
  bool print_config = false, paper = false;
  SequenceRunOptions sequence;
  LogRunOptions log;
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
  if (!options.maps_folder.empty()) config.maps_folder = options.maps_folder;
  if (options.localize_only) config.mapper.localize_only = true;
  if (options.metrics_port) config.metrics_port = *options.metrics_port;
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

int run_logged(LogRunOptions options, const std::filesystem::path& output,
               const ServerConfig& config, StopSignals& signals) {
  if (output.empty())
    throw std::invalid_argument("--log needs --output FOLDER, for trajectories, map and report");
  options.output = output;
  options.config = config;
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  bool interrupted = false;
  const auto progress = [&](int done, int total) {
    bar.show(done, total);
    interrupted = interrupted || (done != total && signals.arrived());
    return !interrupted;
  };
  const LogRunResult result =
      run_log(options, progress, [](const std::string& note) { spdlog::warn(note); });
  if (!result.problem.empty()) {
    spdlog::error(result.problem);
    return kFailed;
  }
  if (interrupted)
    spdlog::warn("interrupted: the results in {} are partial", output.string());
  else
    spdlog::info("{}; results are in {}", result.summary, output.string());
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

// Neither server nor problem where none is wanted.
MetricsServer::Opened open_metrics(const ServerConfig& config, MappingServer& server) {
  if (config.metrics_port == 0) return {};
  auto opened = MetricsServer::open(config.metrics_at(),
                                    [&server] { return metrics_text(server.statuses()); });
  if (!opened.server) return opened;
  spdlog::info("metrics at {}", opened.server->url());
  if (!config.metrics_at().loopback())
    spdlog::warn("whoever reaches {} can read the metrics", config.metrics_address);
  return opened;
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
  ServerConfig kept = config;
  kept.keeps_results = !output.empty();
  MappingServer server(kept, *opened.bus, log_change);
  const MetricsServer::Opened metrics = open_metrics(config, server);
  if (!metrics.problem.empty()) {
    spdlog::error(metrics.problem);
    return kFailed;
  }
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

int run_check(const std::filesystem::path& file, bool repair) {
  const MapCheck check = check_map(file, repair);
  std::cout << check.said << '\n';
  return check.ok ? 0 : kFailed;
}

int run(const Options& options, StopSignals& signals) {
  try {
    if (!options.check_map.empty()) return run_check(options.check_map, options.repair);
    const ServerConfig config = effective_config(options);
    if (options.print_config) {
      std::cout << config_text(config) << '\n';
      return 0;
    }
    if (!options.log.log.empty())
      return run_logged(options.log, options.sequence.output, config, signals);
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
  app.add_flag("--localize-only", options.localize_only,
               "track in maps that were made before, and change nothing of them");
  CLI::Option* check = app.add_option("--check-map", options.check_map,
                                      "say what of a map's file is whole, and stop");
  app.add_flag("--repair", options.repair, "cut it to what is whole, and keep a copy of all of it")
      ->needs(check);
  app.add_option("--output", sequence.output, "folder for trajectories, map and report");

  app.add_option("--lcm-url", options.lcm_url, "network to listen and publish on")->group(kLive);
  app.add_option("--camera", options.camera,
                 "the only camera to map; default: every one that is heard, up to max_cameras")
      ->group(kLive);
  app.add_option("--maps", options.maps_folder,
                 "folder where maps are kept: after a restart mapping goes on with them")
      ->group(kLive);
  app.add_option("--input", options.input, "newest: keep up; lossless: take every frame")
      ->check(one_of(std::vector<std::string>{"newest", "lossless"}))
      ->group(kLive);
  app.add_option("--metrics-port", options.metrics_port,
                 "serve figures for Prometheus at http://127.0.0.1:PORT/metrics; 0, the default: "
                 "none")
      ->check(number_in(0, 65535))
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
  app.add_option("--first-frame", sequence.first_frame, "image to begin with, from 0")
      ->check(number_in(0))
      ->group(kRecorded);
  app.add_option("--load-map", sequence.load_map,
                 "map to begin with: a file of --save-map or --maps")
      ->group(kRecorded);
  app.add_option("--save-map", sequence.save_map, "file for the map that there is in the end")
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

  LogRunOptions& log = options.log;
  app.add_option("--log", log.log,
                 "a log of eifmap.* that lcm-logger wrote: map it as the server did that it heard, "
                 "or, where it heard none, every frame")
      ->group(kLogged);
  app.add_flag("--verify", log.verify,
               "end with 1 where a frame comes out otherwise than recorded, and say which")
      ->group(kLogged);
  app.add_option("--epoch", log.epoch,
                 "server_epoch of the run to make again; default: the one with most decisions")
      ->group(kLogged);
}

// Options of one way to run with another one.
std::string mixed_options(const CLI::App& app) {
  const bool recorded = app.get_option("--sequence")->count() > 0;
  const bool logged = app.get_option("--log")->count() > 0;
  if (recorded && logged) return "--sequence and --log are two runs: leave one of them out";
  if (app.get_option("--decisions")->count() > 0)
    for (const char* option :
         {"--every", "--first-frame", "--max-frames", "--jitter-px", "--load-map"})
      if (app.get_option(option)->count() > 0)
        return std::string(option) + " is of another run than the one in --decisions: leave it out";
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    if (logged && option->get_name() == "--camera") continue;
    if ((recorded || logged) && option->get_group() == kLive)
      return option->get_name() + " is of a live server, and " +
             (recorded ? "--sequence" : "--log") + " maps without a network: leave one of them out";
    if (!logged && option->get_group() == kLogged)
      return option->get_name() + " is of a log: give it by --log, or leave it out";
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
