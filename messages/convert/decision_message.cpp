#include "convert/decision_message.h"

#include "convert/pose_fields.h"
#include "wire/channel.h"
#include "wire/layout.h"

namespace eifmap {
namespace {

void scan(LayoutScanner& in) {
  in.skip(4 * 8);  // utime to server_epoch
  in.string("camera", kMaxText);
  in.skip(8);  // job
  in.array("measurements", in.count("num_measurements", kMaxEntries), 2 * 8);
  in.skip(1 + 8);  // after_reset, digest
}

std::string problem(const decision_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (message.adopted_job < kAdoptedAtOnce)
    return "adopted_job is " + std::to_string(message.adopted_job);
  if (message.after_reset != 0 && message.after_reset != 1)
    return "after_reset is " + std::to_string(message.after_reset);
  for (const measurement_id_t& id : message.measurements)
    if (id.seq < 0 || !valid_seq(id.seq)) return "a measurement's seq is " + std::to_string(id.seq);
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
  for (const MeasurementId& id : decision.decision.measurements) {
    message.measurements.emplace_back();
    message.measurements.back().publisher = id.publisher;
    message.measurements.back().seq = id.seq;
  }
  message.num_measurements = static_cast<std::int32_t>(message.measurements.size());
  message.after_reset = decision.decision.after_reset ? 1 : 0;
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
  Decision& decision = result.value.decision;
  decision = {message.utime, message.publisher, message.input_seq, message.adopted_job,
              message.state_digest};
  for (const measurement_id_t& id : message.measurements)
    decision.measurements.push_back({id.publisher, id.seq});
  decision.after_reset = message.after_reset != 0;
  return result;
}

}  // namespace eifmap
