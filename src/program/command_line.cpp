#include "program/command_line.h"

#include <algorithm>
#include <cmath>

#include "geometry/camera.h"
#include "program/nearest_name.h"
#include "sequence/number_text.h"

namespace eifmap {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

std::string unknown(const std::string& text, const std::vector<std::string>& names) {
  return "'" + text + "' is unknown, wanted " + listed(names);
}

std::vector<std::string> known_names(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  if (word.starts_with("-")) {
    for (const CLI::Option* option : app.get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  } else {
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  }
  return names;
}

}  // namespace

void add_calibration_options(CLI::App& app, SequenceOptions& options) {
  app.add_option("--calib,--calibration", options.calibration,
                 "calibration of the images: calib.json, or camera_info as YAML");
  app.add_option("--hfov", options.hfov_deg,
                 "guess the calibration: what the camera sees from left to right, degrees")
      ->check(number_in(kMinHfovDeg, kMaxHfovDeg));
}

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    app.exit(error);
    return "";
  }
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  const CLI::App& used = parsed.empty() ? app : *parsed.front();
  const std::string program =
      parsed.empty() ? app.get_name() : app.get_name() + " " + used.get_name();
  const std::string help = program + " --help shows what there is";
  const std::vector<std::string> extras = app.remaining(true);
  if (extras.empty()) return std::string(error.what()) + "; " + help;
  const std::string word = extras.front().substr(0, extras.front().find('='));
  return "'" + word + "' means nothing to " + program +
         did_you_mean(word, known_names(used, word)) + "; " + help;
}

CLI::Validator one_of(const std::vector<std::string>& names) {
  return CLI::Validator(
      [names](const std::string& text) {
        const bool known = std::find(names.begin(), names.end(), text) != names.end();
        return known ? "" : unknown(text, names);
      },
      listed(names));
}

CLI::Validator one_of(const std::vector<std::pair<std::string, int>>& values) {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.push_back(name);
  return CLI::Validator(
      [values, names](std::string& text) {
        for (const auto& [name, value] : values)
          if (name == text) {
            text = std::to_string(value);
            return std::string();
          }
        return unknown(text, names);
      },
      listed(names));
}

CLI::Validator number_in(double min, double max) {
  const auto text_of = [](double x) {
    // Else 100000 would be 1e+05.
    return x == std::floor(x) ? std::to_string(std::llround(x)) : exact_text(x);
  };
  const std::string wanted =
      std::isfinite(max) ? text_of(min) + " to " + text_of(max) : text_of(min) + " or more";
  return CLI::Validator(
      [min, max, wanted](const std::string& text) {
        const auto value = parse_number(text);
        const bool good = value && *value >= min && *value <= max && std::isfinite(*value);
        return good ? "" : "'" + text + "' is out of range, wanted " + wanted;
      },
      wanted);
}

}  // namespace eifmap
