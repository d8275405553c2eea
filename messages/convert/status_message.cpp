#include "convert/status_message.h"

#include "convert/earth_fields.h"
#include "convert/layout.h"
#include "convert/limits.h"
#include "convert/scale_fields.h"

namespace eifmap {
namespace {

void scan(LayoutScanner& in) {
  in.skip(2 * 8);  // utime, start_utime
  for (const char* name : {"name", "version", "host", "camera"}) in.string(name, kMaxText);
  in.skip(4 + 4 * 8);             // pid; epochs and map
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

}  // namespace

Decoded<status_t> decode_status(Bytes bytes) {
  Decoded<status_t> decoded = decode_checked<status_t>(bytes, scan);
  if (!decoded.ok()) return decoded;
  const status_t& status = decoded.value;
  if (status.state < status_t::STATE_WAITING || status.state > status_t::STATE_STOPPING)
    return Decoded<status_t>::refuse(Reason::kMalformedMessage,
                                     "state is " + std::to_string(status.state));
  if (status.level < status_t::LEVEL_OK || status.level > status_t::LEVEL_ERROR)
    return Decoded<status_t>::refuse(Reason::kMalformedMessage,
                                     "level is " + std::to_string(status.level));
  if (!valid_scale(status))
    return Decoded<status_t>::refuse(Reason::kMalformedMessage, "the scale is no scale");
  if (!valid_earth(status))
    return Decoded<status_t>::refuse(
        Reason::kMalformedMessage,
        "earth is " + std::to_string(status.earth) + ", or its pose is no pose");
  return decoded;
}

}  // namespace eifmap
