#include "wire/layouts.h"

#include "wire/limits.h"

namespace eifmap {

void scan_pose(LayoutScanner& in) {
  in.skip(7 * 8);  // utime to map_seq
  in.string("camera", kMaxText);
  // state, source, covariance_status, reason; pose; covariance; reference; scale; matches, inliers
  in.skip(3 + 2 + 7 * 8 + 36 * 8 + 8 + 7 * 8 + 1 + 2 * 8 + 2 * 4);
}

void scan_status(LayoutScanner& in) {
  in.skip(2 * 8);  // utime, start_utime
  for (const char* name : {"name", "version", "host", "camera"}) in.string(name, kMaxText);
  in.skip(4 + 5 * 8 + 1);         // pid; epochs and map; map_is_safe
  in.skip(1 + 2 * 8);             // scale
  in.skip(1 + (3 + 4 + 36) * 8);  // earth
  in.skip(1 + 1 + 2);             // state, level, reason
  for (const char* name : {"message", "hint"}) in.string(name, kMaxText);
  in.skip(8 * 8 + 4 * 4 + 4 * 4 + 4 +
          8);  // counters; rates, latencies; counts; nis_ratio; rss_bytes
  const std::size_t n = in.count("num_diagnostics", kMaxText);
  for (std::size_t i = 0; i < n && in.ok(); ++i)
    for (const char* name : {"diagnostic key", "diagnostic value"}) in.string(name, kMaxText);
}

}  // namespace eifmap
