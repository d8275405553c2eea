// What the programs' command lines have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "sequence/sequence_options.h"

namespace eifmap {

// --calib (also as --calibration) and --hfov.
void add_calibration_options(CLI::App& app, SequenceOptions& options);

// One sentence: what is wrong with the command line, and what to do. "" when help or the version
// was asked for, which is printed.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

// Checks of an option's value; what they say names the value and what is wanted.
CLI::Validator one_of(const std::vector<std::string>& names);
CLI::Validator number_in(double min, double max = std::numeric_limits<double>::infinity());

// The same for an option that is an enumeration: pairs of name and value.
CLI::Validator one_of(const std::vector<std::pair<std::string, int>>& values);

template <class Pairs>
std::vector<std::pair<std::string, int>> as_numbers(const Pairs& pairs) {
  std::vector<std::pair<std::string, int>> numbers;
  for (const auto& [name, value] : pairs) numbers.emplace_back(name, static_cast<int>(value));
  return numbers;
}

}  // namespace eifmap
