// Runs cases that mapping with one camera finds hard, several seeds of each.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <opencv2/core/utility.hpp>

#include "degenerate/judgement.h"

namespace {

using namespace eifmap;
using namespace eifmap::test;

constexpr int kFailed = 1, kBadOptions = 2;

struct Options {
  std::vector<std::string> cases;
  int seeds = 3, first_seed = 1, frames = 0;
  bool verbose = false;
};

void print_results(const CaseRun& run) {
  for (std::size_t i = 0; i < run.results.size(); ++i) {
    const FrameResult& result = run.results[i];
    const Eigen::Vector3d at = result.map_from_camera.translation;
    const Eigen::Vector3d truth = run.truth[i].world_from_camera.translation;
    std::printf(
        "    %zu state %d map %d source %d at %.4f %.4f %.4f, true %.4f %.4f %.4f moving %d %s "
        "%s\n",
        i, static_cast<int>(result.state), static_cast<int>(result.map_id),
        static_cast<int>(result.source), at.x(), at.y(), at.z(), truth.x(), truth.y(), truth.z(),
        result.num_moving, describe(result.reason).name, result.detail.c_str());
  }
}

bool run(const Case& which, int seed, int frames, bool verbose) {
  SimulationOptions options = which.world;
  options.seed = seed;
  if (frames > 0) options.num_frames = std::min(frames, options.num_frames);
  const SimulatedWorld world(options);
  const CaseRun run = run_case(which, world);
  const Verdict verdict = judge(which, world, run);
  std::printf("%s, seed %d:%s\n", which.name.c_str(), seed, verdict.summary.c_str());
  for (const std::string& fault : verdict.faults) std::printf("  FAILED: %s\n", fault.c_str());
  if (verbose) print_results(run);
  std::fflush(stdout);
  return verdict.faults.empty();
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  Options options;
  CLI::App app("Cases that end in a stated state, never in a wrong map", "degenerate");
  app.add_option("cases", options.cases, "names; none: all");
  app.add_option("--seeds", options.seeds, "runs of each");
  app.add_option("--first-seed", options.first_seed, "of the first run");
  app.add_option("--frames", options.frames, "of each at most; 0: all");
  app.add_flag("--verbose", options.verbose, "what was said of every image");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.cases.empty())
      for (const Case& which : all_cases()) options.cases.push_back(which.name);
    bool good = true;
    for (const std::string& name : options.cases) {
      const Case* which = find_case(name);
      if (!which) {
        std::fprintf(stderr, "degenerate: no case '%s'\n", name.c_str());
        return kBadOptions;
      }
      for (int i = 0; i < options.seeds; ++i)
        good = run(*which, options.first_seed + i, options.frames, options.verbose) && good;
    }
    return good ? 0 : kFailed;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "degenerate: %s\n", error.what());
    return kBadOptions;
  }
}
