// What a map of thousands of keyframes costs: the filter is fed keyframe by keyframe, and time and
// memory are written as it grows. src/filter/size.md is made of it (plot_size.py).
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

#include "support/long_way.h"

namespace {

using namespace eifmap;
using namespace eifmap::test;

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_rss_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Of a line of /proc/self/status, in kB.
double rss_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

struct Options {
  int keyframes = 5000, lap = 5200, every = 250;
  double points = 54;  // made for each keyframe; about 50 of them are seen three times
  bool copies = false;
  std::string csv;
};

int run(const Options& options) {
  const double before_world = rss_mib();
  const LongWay world = make_long_way(round_course(options.keyframes, options.lap),
                                      {.points_per_pose = options.points});
  const double of_world = rss_mib() - before_world;
  std::printf("%d keyframes, %zu points, %zu sights in sight, the world itself %.0f MiB\n",
              options.keyframes, world.points.size(), world.num_sights(), of_world);
  std::ofstream csv(options.csv);
  csv << "keyframes,landmarks,observations,ms_median,ms_p99,ms_copy,rss_mib,peak_rss_mib\n";
  LongWayFeed feed(world, FilterOptions{});
  InformationFilter copy(FilterOptions{}, 1);
  std::vector<double> ms;
  double copying = 0;
  const double begin = cpu_seconds();
  while (!feed.done()) {
    feed.add_next();
    const double before = cpu_seconds();
    feed.filter().update();
    const double updated = cpu_seconds();
    ms.push_back(1e3 * (updated - before));
    if (options.copies) {
      copy = feed.filter();
      copying += 1e3 * (cpu_seconds() - updated);
    }
    if (feed.num_poses() % options.every != 0 && !feed.done()) continue;
    std::sort(ms.begin(), ms.end());
    const InformationFilter& filter = feed.filter();
    char line[256];
    std::snprintf(line, sizeof line, "%d,%d,%zu,%.2f,%.2f,%.2f,%.0f,%.0f", filter.num_poses(),
                  filter.num_landmarks(), filter.num_measurements(), ms[ms.size() / 2],
                  ms[ms.size() * 99 / 100], copying / static_cast<double>(ms.size()), rss_mib(),
                  peak_rss_mib());
    csv << line << std::endl;
    std::printf("%s  (%.0f s CPU)\n", line, cpu_seconds() - begin);
    std::fflush(stdout);
    ms.clear();
    copying = 0;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Time and memory of the filter as its map grows", "eifmap_large_map");
  app.add_option("--keyframes", options.keyframes, "of the way");
  app.add_option("--lap", options.lap, "keyframes after which the way is gone again");
  app.add_option("--every", options.every, "keyframes a line is written of");
  app.add_option("--points", options.points, "made for each keyframe");
  app.add_flag("--copies", options.copies,
               "also a copy of the filter per keyframe, as the mapper's of its map");
  app.add_option("--csv", options.csv, "file for the figures")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "eifmap_large_map: %s\n", error.what());
    return 1;
  }
}
