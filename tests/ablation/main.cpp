// ablation: what each part of the method is worth, as a page of tables.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <opencv2/core/utility.hpp>

#include "ablation/page.h"

namespace {

using namespace eifmap::test;

struct Options {
  RunOptions run;
  int max_frames = 0;
  std::string rows, output, dump;
  std::vector<std::string> recordings{"kitti00", "kitchen", "courtyard"};
};

std::filesystem::path data_folder() {
  const char* shared = std::getenv("EIFMAP_SHARED");
  const std::filesystem::path beside =
      std::filesystem::path(EIFMAP_SOURCE_DIR).parent_path() / "shared";
  return (shared ? std::filesystem::path(shared) : beside) / "data";
}

// "" when there is none.
std::string read_page(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const std::string& file, const std::string& text, std::ios::openmode mode) {
  std::ofstream out(file, std::ios::binary | mode);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(file + ": cannot be written");
}

std::vector<Recording> open_recordings(const Options& options, Results& results) {
  std::vector<Recording> recordings;
  for (const std::string& name : options.recordings)
    if (auto recording = open_recording(name, data_folder(), options.max_frames))
      recordings.push_back(std::move(*recording));
    else
      results.skipped.push_back(name);
  for (const std::string& name : results.skipped)
    std::cerr << name << ": skipped, not in " << data_folder().string() << '\n';
  return recordings;
}

void run(const Options& options) {
  Results results;
  results.rows = rows_with(options.rows);
  results.seeds = options.run.seeds;
  if (results.rows.empty()) throw std::invalid_argument("--rows: no row has that text");
  // Before the long work: a page that cannot be written is found out at once.
  if (!options.output.empty()) page_with_tables(read_page(options.output), "");
  if (!options.dump.empty()) write(options.dump, "", std::ios::trunc);

  const std::vector<Recording> recordings = open_recordings(options, results);
  double estimate = 0;
  for (const Recording& recording : recordings)
    estimate += estimated_cpu_s(recording, results.rows, options.run);
  std::cerr << "about " << std::max(1.0, std::round(estimate / 60)) << " minutes of CPU time\n";

  for (const Recording& recording : recordings) {
    const Say say = [&](const std::string& done) {
      std::cerr << recording.name << ": " << done << '\n';
    };
    results.recordings.push_back({recording.name, recording.size(), recording.truth_is_exact,
                                  run_rows(recording, results.rows, options.run, say)});
    if (!options.dump.empty())
      write(options.dump, json_lines(results.rows, results.recordings.back()), std::ios::app);
  }
  const std::string tables = tables_text(results);
  if (options.output.empty())
    std::cout << tables;
  else
    write(options.output, page_with_tables(read_page(options.output), tables), std::ios::trunc);
  std::cerr << "took " << std::round(static_cast<double>(std::clock()) / CLOCKS_PER_SEC / 6) / 10
            << " minutes of CPU time\n";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What each part of the method is worth: every row's runs, as a page of tables.");
  Options options;
  app.add_option("--seeds", options.run.seeds, "runs of each row, with noise of their own")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--slow-seeds", options.run.slow_seeds,
                 "at most, of rows with the Unscented covariance, which take 5 times as long")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--rows", options.rows, "only rows whose \"group: name\" holds this text");
  app.add_option("--sequences", options.recordings,
                 "comma-separated: folders of data, or courtyard")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--max-frames", options.max_frames, "at most so many images of each; 0: all")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--workers", options.run.workers, "threads")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--output", options.output,
                 "page whose tables are to be replaced, or written anew; none: standard output");
  app.add_option("--dump", options.dump, "every run as a line of JSON, into this file");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::cerr << "ablation: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
