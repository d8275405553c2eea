#pragma once

#include <string>

#include "reason.h"

namespace eifmap {

// Whether something was taken, done or read, and if not, why not.
struct Taken {
  Reason reason = Reason::kNone;
  std::string detail;  // which value was wrong; where nothing was, what its maker says of it
};

}  // namespace eifmap
