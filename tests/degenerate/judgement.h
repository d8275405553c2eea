// Whether a run ended in the state that its case has to end in, and every map is right.
#pragma once

#include <string>
#include <vector>

#include "degenerate/run.h"

namespace eifmap::test {

struct Verdict {
  std::vector<std::string> faults;  // a sentence each; none: as it has to be
  std::string summary;              // states, maps, errors: one line
};

Verdict judge(const Case& which, const SimulatedWorld& world, const CaseRun& run);

}  // namespace eifmap::test
