// eifmap-server: options in, exit code out.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "server/progress_bar.h"
#include "server/sequence_run.h"

namespace {

constexpr int kFailed = 1;

int run(const eifmap::SequenceRunOptions& options) {
  eifmap::ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  const std::string problem = eifmap::run_sequence(options, [&](int done, int total) {
    bar.show(done, total);
    return true;
  });
  if (problem.empty()) return 0;
  std::cerr << "eifmap-server: " << problem << '\n';
  return kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  eifmap::SequenceRunOptions sequence;
  CLI::App app("Maps a camera's images: camera poses and a map of points.");
  app.add_option("--sequence", sequence.sequence, "recorded folder to map, without a network")
      ->required();
  app.add_option("--output", sequence.output, "folder for the results")->required();
  app.add_option("--every", sequence.every, "take every n-th image")->check(CLI::PositiveNumber);
  app.add_option("--max-frames", sequence.max_frames, "stop after so many images; 0: all");
  app.add_option("--jitter-px", sequence.jitter_px, "noise added to the keypoints, px");
  app.add_option("--seed", sequence.seed, "of that noise");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(sequence);
  } catch (const std::exception& error) {
    std::cerr << "eifmap-server: " << error.what() << '\n';
    return kFailed;
  }
}
