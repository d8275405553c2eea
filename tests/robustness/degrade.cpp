// degrade: a recording made worse, as a folder of eifmap's own layout. Called by table.py and
// corrupted.py.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <fstream>
#include <iostream>

#include "program/command_line.h"
#include "robustness/corruption.h"
#include "robustness/degradation.h"

namespace {

using namespace eifmap;
using namespace eifmap::test;

struct Options {
  bool list = false;
  std::string source, folder, how = "as_recorded";
  int corrupt = 0, frames = 0;
  std::vector<std::string> kinds;
  std::uint64_t seed = 0;
  SequenceOptions images;
};

template <class Named>
std::vector<std::string> names(std::span<const Named> all) {
  std::vector<std::string> result;
  for (const Named& each : all) result.emplace_back(each.name);
  return result;
}

// Of a name that has been checked.
template <class Named>
const Named& named(std::span<const Named> all, const std::string& name) {
  return *std::find_if(all.begin(), all.end(),
                       [&](const Named& each) { return each.name == name; });
}

// A line each, with tabs: name, whether it needs seeds, title.
void list() {
  for (const Degradation& each : all_degradations())
    std::cout << each.name << '\t' << each.random << '\t' << each.title << '\n';
}

void corrupt(const RecordedSequence& sequence, const Options& options, Random& random,
             OwnFolder& folder) {
  std::vector<Corruption> kinds;
  for (const CorruptionName& each : all_corruptions())
    if (options.kinds.empty() ||
        std::find(options.kinds.begin(), options.kinds.end(), each.name) != options.kinds.end())
      kinds.push_back(each.kind);
  const int all = sequence.size(),
            frames = options.frames > 0 ? std::min(options.frames, all) : all;
  std::ofstream out(std::filesystem::path(options.folder) / "corrupted.txt", std::ios::binary);
  for (const Corrupted& each :
       write_corrupted(sequence, frames, options.corrupt, kinds, random, folder))
    out << each.time_us << ' ' << all_corruptions()[static_cast<std::size_t>(each.kind)].name
        << '\n';
}

void run(const Options& options) {
  if (options.list) return list();
  if (options.source.empty() || options.folder.empty())
    throw std::invalid_argument("a SOURCE and a FOLDER are needed; --help says more");
  const RecordedSequence::Opened opened = RecordedSequence::open(options.source, options.images);
  if (!opened.sequence) throw std::runtime_error(opened.problem);
  Random random(options.seed);
  OwnFolder folder(options.folder);
  if (options.corrupt > 0) return corrupt(*opened.sequence, options, random, folder);
  named(all_degradations(), options.how).write(*opened.sequence, random, folder);
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  Options options;
  CLI::App app("A recording made worse, as a folder of eifmap's own layout.", "degrade");
  app.add_flag("--list", options.list,
               "what there is for --how: name, whether seeds differ, title");
  app.add_option("SOURCE", options.source, "a recorded folder in any layout");
  app.add_option("FOLDER", options.folder, "to be written; new or empty");
  app.add_option("--how", options.how)->check(one_of(names(all_degradations())));
  app.add_option("--corrupt", options.corrupt,
                 "instead: put so many strange images between the good ones; which and when is in "
                 "FOLDER/corrupted.txt (microseconds, kind)")
      ->check(number_in(1));
  app.add_option("--kinds", options.kinds, "of strange images; default: all")
      ->delimiter(',')
      ->check(one_of(names(all_corruptions())));
  app.add_option("--max-frames", options.frames, "of the good ones, with --corrupt; 0: all")
      ->check(number_in(0));
  app.add_option("--seed", options.seed, "of all that is random");
  add_calibration_options(app, options.images);
  try {
    app.parse(argc, argv);
    run(options);
  } catch (const CLI::ParseError& error) {
    const std::string problem = explain(app, error);
    if (problem.empty()) return 0;
    std::cerr << "degrade: " << problem << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "degrade: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
