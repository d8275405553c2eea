#include "sequence/decisions_file.h"

#include <fstream>
#include <nlohmann/json.hpp>

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;

// Throws Json::exception.
Decision decision_in(const std::string& line) {
  const Json json = Json::parse(line);
  Decision decision;
  json.at("utime").get_to(decision.time_us);
  json.at("publisher").get_to(decision.publisher);
  json.at("seq").get_to(decision.seq);
  json.at("adopted_job").get_to(decision.adopted_job);
  json.at("state_digest").get_to(decision.state_digest);
  return decision;
}

}  // namespace

std::string line_of(const Decision& decision) {
  const Json json = {{"utime", decision.time_us},
                     {"publisher", decision.publisher},
                     {"seq", decision.seq},
                     {"adopted_job", decision.adopted_job},
                     {"state_digest", decision.state_digest}};
  return json.dump();
}

DecisionsFile read_decisions(const std::filesystem::path& file) {
  DecisionsFile read;
  std::ifstream in(file);
  if (!in) return {{}, file.string() + ": cannot be read"};
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty()) continue;
    const auto at = [&] { return file.string() + ":" + std::to_string(number) + ": "; };
    try {
      read.decisions.push_back(decision_in(line));
    } catch (const Json::exception&) {
      return {{}, at() + "is no decision as eifmap log and eifmap-server write them"};
    }
    const auto n = read.decisions.size();
    if (n > 1 && read.decisions[n - 1].time_us <= read.decisions[n - 2].time_us)
      return {{}, at() + "its utime is not after the line before; give the decisions of one run"};
  }
  if (read.decisions.empty()) return {{}, file.string() + ": has no decisions"};
  return read;
}

}  // namespace eifmap
