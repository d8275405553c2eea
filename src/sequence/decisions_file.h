// Decisions as text, a JSON object a line: what a server and a log write, and a replay reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "decision.h"

namespace eifmap {

// Without the line's end. `server_epoch`: of the run, where there may be several; 0 is left out.
std::string line_of(const Decision& decision, std::int64_t server_epoch = 0);

struct DecisionsFile {
  std::vector<Decision> decisions;
  std::string problem;  // "" or what is wrong, with file and line
};
// Of one run: all of one server_epoch, and times must increase.
DecisionsFile read_decisions(const std::filesystem::path& file);

}  // namespace eifmap
