#include "sequence/decisions_file.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "sequence/text_lines.h"

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;

struct Line {
  Decision decision;
  std::int64_t server_epoch = 0;
  std::string problem;
};

// Takes one number after the other out of a line.
class LineReader {
 public:
  explicit LineReader(const std::string& line) : json_(Json::parse(line, nullptr, false)) {}
  void take(const char* key, std::int64_t& value, bool optional = false) {
    const auto found = json_.is_object() ? json_.find(key) : json_.end();
    const bool there = json_.is_object() && found != json_.end();
    if (there && found->is_number_integer())
      value = found->get<std::int64_t>();
    else if (there || !optional)
      ok_ = false;
  }
  // "measurements": [[publisher, seq], ...], left out where there are none.
  void take(std::vector<MeasurementId>& ids) {
    const auto found = json_.is_object() ? json_.find("measurements") : json_.end();
    if (!json_.is_object() || found == json_.end()) return;
    ok_ = ok_ && found->is_array();
    if (!ok_) return;
    for (const Json& id : *found) {
      ok_ = ok_ && id.is_array() && id.size() == 2 && id[0].is_number_integer() &&
            id[1].is_number_integer();
      if (!ok_) return;
      ids.push_back({id[0].get<std::int64_t>(), id[1].get<std::int64_t>()});
    }
  }
  // Left out where it is false.
  void take(const char* key, bool& value) {
    const auto found = json_.is_object() ? json_.find(key) : json_.end();
    if (!json_.is_object() || found == json_.end()) return;
    ok_ = ok_ && found->is_boolean();
    if (ok_) value = found->get<bool>();
  }
  bool ok() const { return ok_; }

 private:
  Json json_;
  bool ok_ = true;
};

Line read_line(const std::string& text) {
  Line line;
  Decision& decision = line.decision;
  LineReader in(text);
  in.take("utime", decision.time_us);
  in.take("publisher", decision.publisher);
  in.take("seq", decision.seq);
  in.take("adopted_job", decision.adopted_job);
  in.take(decision.measurements);
  in.take("after_reset", decision.after_reset);
  in.take("state_digest", decision.state_digest);
  in.take("server_epoch", line.server_epoch, true);
  if (!in.ok()) line.problem = "is no decision as eifmap log and eifmap-server write them";
  return line;
}

// Why `line` cannot follow `before` in one run.
std::string problem_after(const Line& before, const Line& line) {
  if (line.server_epoch != before.server_epoch)
    return "another run of the server begins; give the lines of one run alone";
  if (line.decision.time_us <= before.decision.time_us)
    return "its utime is not after the line before; give the decisions of one run";
  return "";
}

}  // namespace

std::string line_of(const Decision& decision, std::int64_t server_epoch) {
  Json json = {{"utime", decision.time_us},
               {"publisher", decision.publisher},
               {"seq", decision.seq},
               {"adopted_job", decision.adopted_job},
               {"state_digest", decision.state_digest}};
  for (const MeasurementId& id : decision.measurements)
    json["measurements"].push_back({id.publisher, id.seq});
  if (decision.after_reset) json["after_reset"] = true;
  if (server_epoch != 0) json["server_epoch"] = server_epoch;
  return json.dump();
}

DecisionsFile read_decisions(const std::filesystem::path& file) {
  DecisionsFile read;
  Line before;
  read.problem = for_each_text(file, [&](const std::string& text) {
    Line line = read_line(text);
    if (line.problem.empty() && !read.decisions.empty()) line.problem = problem_after(before, line);
    if (!line.problem.empty()) return line.problem;
    read.decisions.push_back(line.decision);
    before = std::move(line);
    return std::string();
  });
  if (!read.problem.empty()) return {{}, read.problem};
  if (read.decisions.empty()) return {{}, file.string() + ": has no decisions"};
  return read;
}

}  // namespace eifmap
