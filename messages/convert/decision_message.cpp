#include "convert/decision_message.h"

#include "convert/channel.h"
#include "convert/layout.h"
#include "convert/pose_fields.h"

namespace eifmap {
namespace {

void scan(LayoutScanner& in) {
  in.skip(4 * 8);  // utime to server_epoch
  in.string("camera", kMaxText);
  in.skip(2 * 8);  // job, digest
}

std::string problem(const decision_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (message.adopted_job < kAdoptedAtOnce)
    return "adopted_job is " + std::to_string(message.adopted_job);
  return "";
}

}  // namespace

decision_t to_message(const PublishedDecision& decision) {
  decision_t message;
  message.utime = decision.decision.time_us;
  message.publisher = decision.decision.publisher;
  message.input_seq = decision.decision.seq;
  message.server_epoch = decision.origin.server_epoch;
  message.camera = decision.origin.camera;
  message.adopted_job = decision.decision.adopted_job;
  message.state_digest = decision.decision.state_digest;
  return message;
}

Decoded<PublishedDecision> decode_decision(Bytes bytes) {
  using Result = Decoded<PublishedDecision>;
  const Decoded<decision_t> decoded = decode_checked<decision_t>(bytes, scan);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  const decision_t& message = decoded.value;
  if (std::string found = problem(message); !found.empty())
    return Result::refuse(Reason::kMalformedMessage, found);
  Result result;
  result.value.origin = {message.server_epoch, message.camera};
  result.value.decision = {message.utime, message.publisher, message.input_seq, message.adopted_job,
                           message.state_digest};
  return result;
}

}  // namespace eifmap
