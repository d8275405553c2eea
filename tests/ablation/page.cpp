#include "ablation/page.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "names.h"

namespace eifmap::test {
namespace {

constexpr const char* kBegin = "<!-- tables: written by tests/ablation/run, do not edit -->\n";
constexpr const char* kEnd = "<!-- end of tables -->\n";

std::string text(double x, int decimals) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(decimals) << x;
  return out.str();
}

template <class Figure>
std::vector<double> figures(std::span<const Outcome> outcomes, const Figure& figure) {
  std::vector<double> all;
  for (const Outcome& outcome : outcomes) all.push_back(figure(outcome));
  return all;
}

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (const double each : x) sum += each;
  return sum / static_cast<double>(x.size());
}

std::vector<Outcome> not_lost(std::span<const Outcome> outcomes) {
  std::vector<Outcome> rest(outcomes.begin(), outcomes.end());
  std::erase_if(rest, [](const Outcome& outcome) { return outcome.lost(); });
  return rest;
}

// Lost runs have no error that could be averaged: the mean is of the others, the worst is "lost".
std::string error_cell(std::span<const Outcome> outcomes) {
  const std::vector<Outcome> rest = not_lost(outcomes);
  if (rest.empty()) return "**lost**";
  const std::vector<double> errors = figures(rest, [](const Outcome& o) { return *o.ate_m; });
  const size_t lost = outcomes.size() - rest.size();
  const std::string worst =
      lost == 0 ? text(*std::max_element(errors.begin(), errors.end()), 3)
                : "**lost** " + std::to_string(lost) + " of " + std::to_string(outcomes.size());
  return text(mean(errors), 3) + " / " + worst;
}

// Rounded down: what is called 1.000 is all.
std::string coverage_cell(std::span<const Outcome> outcomes) {
  const std::vector<double> all = figures(outcomes, [](const Outcome& o) { return o.coverage; });
  return text(std::floor(1000 * *std::min_element(all.begin(), all.end()) + 1e-9) / 1000, 3);
}

std::string nees_cell(std::span<const Outcome> outcomes) {
  std::vector<Outcome> judged = not_lost(outcomes);
  std::erase_if(judged, [](const Outcome& outcome) { return !outcome.nees; });
  if (judged.empty()) return "-";
  const double nees = mean(figures(judged, [](const Outcome& o) { return *o.nees; }));
  return std::isfinite(nees) ? text(nees, nees < 100 ? 1 : 0) : "no bound";
}

std::string cpu_cell(std::span<const Outcome> outcomes) {
  const auto cpu = [](const Outcome& o) { return o.extraction_ms + o.mapper_ms; };
  return text(mean(figures(outcomes, cpu)), 1);
}

std::string header_text(const Results& results) {
  std::string names = "| | images |", rule = "|---|---|";
  for (const RecordingResult& recording : results.recordings) {
    names += ' ' + recording.name + ": error (m), mean / worst | coverage |";
    rule += "---:|---:|";
    if (recording.truth_is_exact) names += " NEES |", rule += "---:|";
    names += " CPU ms |";
    rule += "---:|";
  }
  return names + '\n' + rule + '\n';
}

std::string seeds_text(size_t seeds) {
  return std::to_string(seeds) + (seeds == 1 ? " seed" : " seeds");
}

// Slow rows have been run less often, and say so.
std::string fewer_seeds(const Results& results, size_t row) {
  if (results.recordings.empty()) return "";
  const size_t seeds = results.recordings[0].outcomes.at(row).size();
  return seeds == static_cast<size_t>(results.seeds) ? "" : " (" + seeds_text(seeds) + ')';
}

std::string row_text(const Results& results, size_t row) {
  std::string line = "| " + results.rows[row].name;
  line += fewer_seeds(results, row) + " | " + rate_text(results.rows[row].every) + " |";
  for (const RecordingResult& recording : results.recordings) {
    const std::span<const Outcome> outcomes = recording.outcomes.at(row);
    line += ' ' + error_cell(outcomes) + " | " + coverage_cell(outcomes) + " |";
    if (recording.truth_is_exact) line += ' ' + nees_cell(outcomes) + " |";
    line += ' ' + cpu_cell(outcomes) + " |";
  }
  return line + '\n';
}

std::string what_was_run(const Results& results) {
  std::ostringstream out;
  out << "Each row is the defaults with one thing changed, on";
  for (const RecordingResult& recording : results.recordings)
    out << (&recording == results.recordings.data() ? " " : ", ") << recording.name << " ("
        << recording.images << (recording.truth_is_exact ? " rendered" : " recorded") << " images)";
  for (const std::string& name : results.skipped) out << "; " << name << ": skipped, not there";
  out << ". Each run has " << text(kJitterPx, 2)
      << " px of noise of its own on every keypoint: " << seeds_text(results.seeds)
      << ", fewer where a row says so because it is slow.\n\n"
      << "- Error: RMSE of `trajectory_final.tum` after a similarity transform, mean and worst of "
         "the seeds. **lost**: no trajectory, or one with less than "
      << text(kLostCoverage, 1)
      << " of the images; the mean is of the seeds that were not. An error says nothing about "
         "images that are not covered: read it with the next column.\n"
      << "- Coverage: share of the images given that are in that trajectory, least of the seeds.\n"
      << "- NEES: of the final keyframes' poses by their covariances, mean of the seeds; 6 is "
         "right, more is overconfident. Only where the truth is exact.\n"
      << "- CPU: milliseconds for an image given, features and mapper, one thread, without "
         "decoding; "
         "of the machine at hand, to compare rows.\n\n"
      << "`tests/ablation/run` writes this again, with the recordings in `$EIFMAP_SHARED/data`, or "
         "`../shared/data` beside the project. `tests/ablation/run --rows TEXT` prints the rows "
         "with "
         "that text alone; `--help` says more. A row by itself: `eifmap-server --sequence FOLDER "
         "--jitter-px 0.05 --seed N` with `--every` and the row's change in `--config`; "
         "[rows.cpp](../tests/ablation/rows.cpp) has them.\n";
  return out.str();
}

}  // namespace

std::string tables_text(const Results& results) {
  std::string page = what_was_run(results), group;
  for (size_t row = 0; row < results.rows.size(); ++row) {
    if (results.rows[row].group != group) {
      group = results.rows[row].group;
      page += "\n## " + group + "\n\n" + header_text(results);
    }
    page += row_text(results, row);
  }
  return page;
}

std::string page_with_tables(const std::string& page, const std::string& tables) {
  if (page.empty())
    return "# What each part is worth\n\n" + std::string(kBegin) + '\n' + tables + '\n' + kEnd +
           "\n## What it says\n\n<!-- Written by hand, kept when the tables are written again. "
           "-->\n";
  const size_t begin = page.find(kBegin);
  const size_t end = begin == std::string::npos ? begin : page.find(kEnd, begin);
  if (end == std::string::npos)
    throw std::runtime_error(
        "the page has no markers around its tables: move it away, or put back " +
        std::string(kBegin) + "and " + kEnd);
  return page.substr(0, begin) + kBegin + '\n' + tables + '\n' + page.substr(end);
}

std::string json_lines(std::span<const Row> rows, const RecordingResult& result) {
  using Json = nlohmann::ordered_json;
  const auto or_null = [](const std::optional<double>& x) { return x ? Json(*x) : Json(); };
  std::string lines;
  for (size_t row = 0; row < rows.size(); ++row)
    for (size_t i = 0; i < result.outcomes.at(row).size(); ++i) {
      const Outcome& outcome = result.outcomes[row][i];
      const MapperStatistics& statistics = outcome.statistics;
      Json sources = Json::object();
      for (const auto& [source, count] : statistics.sources)
        sources[std::string(name(source))] = count;
      const Json line{{"recording", result.name},
                      {"group", rows[row].group},
                      {"row", rows[row].name},
                      {"every", rows[row].every},
                      {"paper", rows[row].paper},
                      {"patch", Json::parse(rows[row].patch)},
                      {"seed", i + 1},
                      {"frames", outcome.frames},
                      {"lost", outcome.lost()},
                      {"ate_m", or_null(outcome.ate_m)},
                      {"coverage", outcome.coverage},
                      {"nees", or_null(outcome.nees)},
                      {"extraction_ms", outcome.extraction_ms},
                      {"mapper_ms", outcome.mapper_ms},
                      {"keyframes", statistics.keyframes},
                      {"landmarks", statistics.landmarks},
                      {"edges", statistics.edges},
                      {"starts", statistics.starts},
                      {"losses", statistics.losses},
                      {"pose_sources", sources}};
      lines += line.dump() + '\n';
    }
  return lines;
}

}  // namespace eifmap::test
