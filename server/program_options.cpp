#include "server/program_options.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "program/command_line.h"
#include "sequence/camera_file.h"

namespace eifmap {
namespace {

// Groups of options.
constexpr const char* kLive = "Live, over LCM";
constexpr const char* kRecorded = "Recorded, without a network";
constexpr const char* kLogged = "Of an LCM event log, without a network";

std::string read_file(const std::string& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) throw std::invalid_argument(file + ": cannot be read");
  return text.str();
}

}  // namespace

ServerConfig effective_config(const ServerOptions& options) {
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

void add_options(CLI::App& app, ServerOptions& options) {
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

}  // namespace eifmap
