#include "convert/status_message.h"

#include "convert/earth_fields.h"
#include "convert/scale_fields.h"
#include "wire/layouts.h"

namespace eifmap {
Decoded<status_t> decode_status(Bytes bytes) {
  Decoded<status_t> decoded = decode_checked<status_t>(bytes, scan_status);
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
