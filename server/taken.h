#pragma once

#include <string>

#include "reason.h"

namespace eifmap {

// Whether something was taken, done or read, and if not, why not and which value was wrong.
struct Taken {
  Reason reason = Reason::kNone;
  std::string detail;
};

}  // namespace eifmap
