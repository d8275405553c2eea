#include "published/map_request.h"

#include <random>

#include "wire/channel.h"
#include "wire/layout.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr std::size_t kMissingBytes = 8 + 4 + 1;

void scan(LayoutScanner& in) {
  in.skip(3 * 8);  // utime to request_id
  in.string("camera", kMaxText);
  in.skip(2 * 8);  // server_epoch, have_seq
  in.array("missing", in.count("num_missing", kMaxMissing), kMissingBytes);
}

std::string problem(const map_request_t& request) {
  if (!valid_camera_name(request.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(request.utime)) return "utime is " + std::to_string(request.utime);
  if (request.requester == 0) return "requester is 0: nobody asks";
  if (!valid_seq(request.have_seq)) return "have_seq is " + std::to_string(request.have_seq);
  for (const missing_part_t& missing : request.missing)
    if (missing.seq < 1 || missing.seq > kMaxSeq || missing.part < kAllParts ||
        missing.part >= kMaxParts || (missing.whole != 0 && missing.whole != 1))
      return "part " + std::to_string(missing.part) + " of update " + std::to_string(missing.seq) +
             " cannot be missing";
  return "";
}

}  // namespace

std::int64_t random_requester() {
  std::random_device device;
  const std::uint64_t bits = std::uint64_t{device()} << 32 | device();
  return static_cast<std::int64_t>(bits | 1);
}

Decoded<map_request_t> decode_map_request(Bytes bytes) {
  return decode_checked<map_request_t>(bytes, scan, problem);
}

}  // namespace eifmap
