// Decisions as text, a JSON object a line: what a server and a log write, and a replay reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "decision.h"

namespace eifmap {

// Without the line's end.
std::string line_of(const Decision& decision);

struct DecisionsFile {
  std::vector<Decision> decisions;
  std::string problem;  // "" or what is wrong, with file and line
};
// Times must increase.
DecisionsFile read_decisions(const std::filesystem::path& file);

}  // namespace eifmap
