#include "ablation/rows.h"

#include <stdexcept>

namespace eifmap::test {
namespace {

class Table {
 public:
  Table(std::vector<Row>& rows, std::string group) : rows_(rows), group_(std::move(group)) {}

  Table& row(std::string name, std::string patch, std::initializer_list<int> rates = {1}) {
    for (const int every : rates) rows_.push_back({group_, name, patch, every, false});
    return *this;
  }

  Table& paper(std::string name, std::string patch, std::initializer_list<int> rates) {
    for (const int every : rates) rows_.push_back({group_, name, patch, every, true});
    return *this;
  }

 private:
  std::vector<Row>& rows_;
  std::string group_;
};

// Without the fallback, which would hide what a start is worth.
std::string start(const std::string& name) {
  return R"({"mapper": {"tracking": {"start": ")" + name + R"(", "fall_back": false}}})";
}

}  // namespace

std::vector<Row> all_rows() {
  std::vector<Row> rows;
  Table(rows, "Frame rate").row("defaults", "{}", {1, 2, 5, 10});
  Table(rows, "Start of a new pose, with nothing to fall back on")
      .row("scale fit", start("scale_fit"), {1, 5, 10})
      .row("same speed", start("same_speed"), {1, 5, 10})
      .row("plain triangulation", start("triangulation"), {1, 5, 10})
      .row("PnP", start("pnp"), {1, 5, 10});
  Table(rows, "Scale fit")
      .row("with votes", R"({"mapper": {"scale_fit": {"method": "vote"}}})", {1, 5, 10})
      .row("plain bisquare", R"({"mapper": {"scale_fit": {"method": "plain"}}})", {1, 5, 10});
  Table(rows, "Relative-pose edges")
      .row("on", R"({"mapper": {"edge": {"enabled": true}}})")
      .row("off", R"({"mapper": {"edge": {"enabled": false}}})");
  Table(rows, "Linearization")
      .row("again past a threshold", R"({"mapper": {"filter": {"relinearize": "threshold"}}})")
      .row("once", R"({"mapper": {"filter": {"relinearize": "once"}}})")
      .row("always", R"({"mapper": {"filter": {"relinearize": "always"}}})");
  Table(rows, "Covariance of a relative pose")
      .row("linear", R"({"mapper": {"relative_pose": {"covariance": "linear"}}})")
      .row("unscented", R"({"mapper": {"relative_pose": {"covariance": "unscented"}}})");
  Table(rows, "Laplacian sign of the map")
      .row("-", R"({"mapper": {"map_sign": "minus"}})")
      .row("+", R"({"mapper": {"map_sign": "plus"}})")
      .row("both", R"({"mapper": {"map_sign": "both"}})")
      .row("by merit", R"({"mapper": {"map_sign": "merit"}})");
  Table(rows, "Smaller choices")
      .row("defaults", "{}")
      .row("three views always", R"({"mapper": {"landmark": {"few_tracked": 0}}})", {1, 5, 10})
      .row("Omega_p promoted", R"({"mapper": {"landmark": {"promote_omega_p": true}}})")
      .row("older reference", R"({"mapper": {"tracking": {"older_reference": true}}})")
      .row("one search for landmarks", R"({"mapper": {"tracking": {"second_search": false}}})")
      .row("edges trusted as they claim", R"({"mapper": {"filter": {"judge_edges": false}}})")
      .row("no refinement", R"({"mapper": {"tracking": {"refine": false}}})");
  Table(rows, "Features")
      .row("SURF upright", R"({"features": {"extractor": "surf_upright"}})")
      .row("SURF oriented", R"({"features": {"extractor": "surf_oriented"}})")
      .row("SIFT", R"({"features": {"extractor": "sift"}})")
      .row("auto", R"({"features": {"extractor": "auto"}})");
  Table(rows, "The paper to the letter")
      .row("defaults", "{}", {1, 5})
      .paper("--paper", "{}", {1, 5})
      .paper("--paper, but linear covariances",
             R"({"mapper": {"relative_pose": {"covariance": "linear"}}})", {1, 5});
  return rows;
}

std::vector<Row> rows_with(std::string_view text) {
  std::vector<Row> rows = all_rows();
  std::erase_if(rows, [text](const Row& row) {
    return (row.group + ": " + row.name).find(text) == std::string::npos;
  });
  return rows;
}

ServerConfig config_of(const Row& row) {
  ServerConfig base;
  if (row.paper) base.mapper = MapperOptions::paper();
  const ParsedConfig parsed = parse_config(row.patch, base);
  const std::string problem = parsed.problem.empty() ? parsed.config.problem() : parsed.problem;
  if (!problem.empty()) throw std::invalid_argument(row.group + ": " + row.name + ": " + problem);
  return parsed.config;
}

std::string rate_text(int every) {
  if (every == 1) return "every image";
  return "every " + std::to_string(every) + (every == 2 ? "nd" : "th") + " image";
}

}  // namespace eifmap::test
