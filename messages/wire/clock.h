// The time of day, for what programs say of themselves. Nothing that is mapped depends on it.
#pragma once

#include <chrono>
#include <cstdint>

namespace eifmap {

// us since the Unix epoch.
inline std::int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace eifmap
