#include <spdlog/spdlog.h>

#include <fstream>
#include <iostream>
#include <optional>

#include "client/commands.h"
#include "program/command_line.h"
#include "sequence/number_text.h"
#include "sequence/trajectory_error.h"

namespace eifmap {
namespace {

struct Options {
  std::string truth, estimate, times;
  bool json = false;
  TrajectoryErrorOptions error;
};

// Nothing when the file cannot be read.
std::optional<int> count_times(const std::string& file) {
  std::ifstream in(file);
  if (!in) return {};
  int count = 0;
  for (std::string line; std::getline(in, line);) count += split_words(line).empty() ? 0 : 1;
  if (!in.eof()) return {};
  return count;
}

int run(Options& options) {
  const TumTrajectory truth = read_tum(options.truth), estimate = read_tum(options.estimate);
  for (const std::string& problem : {truth.problem, estimate.problem}) {
    if (problem.empty()) continue;
    spdlog::error(problem);
    return kFailed;
  }
  if (options.error.num_frames == 0 && !options.times.empty()) {
    const std::optional<int> count = count_times(options.times);
    if (!count) {
      spdlog::error("{}: cannot be read", options.times);
      return kFailed;
    }
    options.error.num_frames = *count;
  }
  const TrajectoryError error = trajectory_error(truth.poses, estimate.poses, options.error);
  std::cout << (options.json ? json_text(error) + "\n" : plain_text(error));
  if (error.aligned) return 0;
  spdlog::error(
      "only {} poses match in time (3 are needed, and a camera that moved): no error figures",
      error.matched);
  return kFailed;
}

}  // namespace

Command add_eval_command(CLI::App& app) {
  auto* command = app.add_subcommand(
      "eval", "trajectory error after the best similarity transform, against the truth");
  const auto options = std::make_shared<Options>();
  command->add_option("--gt", options->truth, "true trajectory, TUM")->required();
  command->add_option("--est", options->estimate, "estimated trajectory, TUM")->required();
  command->add_option("--times", options->times, "times.txt, to count the images for the coverage");
  command->add_option("--nframes", options->error.num_frames, "images there were, for the coverage")
      ->check(number_in(1));
  command->add_option("--max-dt", options->error.max_dt_s, "s between an estimate and its truth")
      ->check(number_in(1e-6));
  command->add_flag("--json", options->json, "one JSON object");
  return [command, options](StopSignals&) { return command->parsed() ? run(*options) : -1; };
}

}  // namespace eifmap
