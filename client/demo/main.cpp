// eifmap-demo: images become a published map, all in one process, and the result is compared with
// the truth and drawn.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "bus/stop_signals.h"
#include "capture/open_source.h"
#include "client/demo/in_process_run.h"
#include "client/demo/top_view.h"
#include "client/view/page_server.h"
#include "program/command_line.h"
#include "program/progress_bar.h"

namespace {

using namespace eifmap;
namespace fs = std::filesystem;

constexpr int kFailed = 1, kBadOptions = 2;

struct Options {
  std::string source, output;
  SequenceOptions sequence;
  int max_frames = 0, port = kDefaultViewPort;
  bool view = false;
  SimulationOptions simulation;
};

template <typename... Values>
std::string print_to_string(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

int fail(const std::string& problem, int code = kFailed) {
  std::cerr << "\ndemo: " << problem << std::endl;
  return code;
}

OpenedSource open_walk(const Options& options) {
  if (!options.source.empty()) {
    OpenedSource opened = open_source(options.source, options.sequence);
    if (opened.source && opened.source->live())
      return {nullptr, options.source +
                           ": is a live camera, and the demo wants a recording; see "
                           "eifmap publish --help"};
    return opened;
  }
  if (std::string problem = options.simulation.problem(); !problem.empty())
    return {nullptr, problem};
  std::cout << "Painting a courtyard to walk through ..." << std::endl;
  return {make_source(SimulatedWorld(options.simulation)), ""};
}

OpenedSource open_images(const Options& options) {
  OpenedSource opened = open_walk(options);
  if (opened.source && options.max_frames > 0)
    opened.source = first_images(std::move(opened.source), options.max_frames);
  return opened;
}

std::string write_truth(const fs::path& file, const std::vector<TumPose>& truth) {
  std::vector<TimedPose> poses;
  for (const TumPose& pose : truth)
    poses.push_back({std::llround(1e6 * pose.time_s), pose.world_from_camera});
  return write_tum(file, poses);
}

std::string describe_error(const TrajectoryError& error) {
  if (!error.aligned) return "too few poses for a trajectory error";
  return print_to_string("%.3f m RMSE, %.2f %% of the %.1f m path; rotation %.2f deg", error.rmse_m,
                         error.percent_of_path(), error.path_m, error.rotation_rmse_deg);
}

struct Outcome {
  TopViewData picture;
  TrajectoryError published, final;
};

// Of the files that the run left.
Outcome evaluate(ImageSource& source, const fs::path& output, InProcessResult run) {
  Outcome outcome;
  TopViewData& picture = outcome.picture;
  picture.path = read_tum(output / "trajectory_final.tum").poses;
  picture.keyframes = read_tum(output / "keyframes.tum").poses;
  picture.points = std::move(run.points);
  picture.truth = source.ground_truth();
  const TrajectoryErrorOptions options{0.05, run.published};
  outcome.published =
      trajectory_error(picture.truth, read_tum(output / "log" / "trajectory.tum").poses, options);
  outcome.final = trajectory_error(picture.truth, picture.path, options);
  if (outcome.final.aligned) picture.truth_from_map = outcome.final.truth_from_estimate;
  picture.title = "eifmap: " + source.name();
  picture.notes.push_back(
      print_to_string("%d images, %zu placed in the map, %zu keyframes, %zu points", run.published,
                      picture.path.size(), picture.keyframes.size(), picture.points.size()));
  if (!picture.truth.empty())
    picture.notes.push_back("error of the path: " + describe_error(outcome.final));
  return outcome;
}

void report(const Outcome& outcome, const fs::path& output) {
  std::cout << '\n' << outcome.picture.notes.front() << '\n';
  if (!outcome.picture.truth.empty())
    std::cout << "error against the truth, after the best similarity transform:\n"
              << "  as published live    " << describe_error(outcome.published) << '\n'
              << "  in the final map     " << describe_error(outcome.final) << '\n';
  std::cout << "in " << output.string() << ":\n"
            << "  top_view.png           the picture of it\n"
            << "  trajectory_final.tum   every image's pose in the final map\n"
            << "  map.ply                the points (MeshLab, CloudCompare, Blender)\n"
            << "  report.json            counts, reasons, times of each step\n"
            << "  log/                   what a client saw: trajectory.tum, poses.jsonl, ...\n";
}

// Keeps the finished map in the browser until a signal comes.
void stay(PageServer& pages, StopSignals& signals) {
  std::cout << "The map stays at " << pages.url() << ": Ctrl-C ends it" << std::endl;
  while (!signals.arrived()) {
    pages.service();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

int run(const Options& options, StopSignals& signals) {
  if (const auto problem = options.sequence.problem(); !problem.empty())
    return fail(problem, kBadOptions);
  const OpenedSource opened = open_images(options);
  if (!opened.source) return fail(opened.problem, kBadOptions);
  const auto& source = opened.source;
  for (const std::string& note : source->notes()) std::cerr << "note: " << note << std::endl;
  View view;
  PageServer::Opened pages;
  if (options.view) {
    pages = PageServer::open({"127.0.0.1", options.port}, view);
    if (!pages.server) return fail(pages.problem);
    std::cout << "Open " << pages.server->url() << " in a browser to see the map grow" << std::endl;
  }
  const fs::path output =
      !options.output.empty()
          ? fs::path(options.output)
          : fs::path("out") / (options.source.empty() ? "demo" : source->name());
  std::cout << "Mapping " << source->size() << " images of " << source->name() << " ("
            << source->kind() << ")"
            << ": server, publisher and logger on one memq:// bus" << std::endl;
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  const InProcessOptions how{output, PublishAs::kRaw, options.view ? &view : nullptr};
  const InProcessResult result = run_in_process(*source, how, [&](int done) {
    bar.show(done, source->size());
    if (pages.server) pages.server->service();
    return !signals.arrived();
  });
  if (!result.problem.empty()) return fail(result.problem);
  if (result.tracked == 0) return fail("no map was made: " + result.last_words);

  const Outcome outcome = evaluate(*source, output, result);
  if (!outcome.picture.truth.empty()) {
    const std::string problem = write_truth(output / "groundtruth.tum", outcome.picture.truth);
    if (!problem.empty()) return fail(problem);
  }
  const fs::path picture = output / "top_view.png";
  if (!cv::imwrite(picture.string(), draw_top_view(outcome.picture)))
    return fail(picture.string() + ": cannot be written");
  report(outcome, output);
  if (pages.server) stay(*pages.server, signals);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  StopSignals signals;
  Options options;
  CLI::App app("Makes a map of a simulated walk, or of a recorded folder, and draws it.",
               "eifmap-demo");
  app.add_option(
      "source", options.source,
      "a folder of images (eifmap, KITTI odometry, TUM RGB-D, EuRoC MAV, or images alone), "
      "or a video; default: a simulated walk");
  add_calibration_options(app, options.sequence);
  app.add_option("--rate", options.sequence.rate_hz, "of images that have no times, a second")
      ->check(number_in(0.001, 10000));
  app.add_option("--output", options.output, "default: out/demo, or out/ and the folder's name");
  app.add_flag("--distorted", options.simulation.distorted, "the simulated walk: a cheap lens");
  app.add_flag("--fisheye", options.simulation.fisheye, "the simulated walk: a fisheye lens");
  app.add_flag("--view", options.view, "show the map in a browser as it grows, and keep it there");
  app.add_option("--port", options.port, "of --view's page; 0: any free one")
      ->capture_default_str();
  app.add_option("--max-frames", options.max_frames, "stop after so many images")
      ->check(number_in(0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const std::string problem = explain(app, error);
    return problem.empty() ? 0 : fail(problem, kBadOptions);
  }
  try {
    return run(options, signals);
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}
