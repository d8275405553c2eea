#include "convert/relative_message.h"

#include "convert/pose_fields.h"
#include "wire/channel.h"
#include "wire/layout.h"

namespace eifmap {
namespace {

void scan_request(LayoutScanner& in) {
  in.skip(3 * 8);  // utime to request_id
  in.string("camera", kMaxText);
  in.skip(3 * 8);  // map_id to keyframe_b
}

void scan_answer(LayoutScanner& in) {
  in.skip(3 * 8);  // utime to request_id
  in.string("camera", kMaxText);
  in.skip(6 * 8 + 2);         // server_epoch to keyframe_b; reason
  in.skip((3 + 4 + 36) * 8);  // pose, covariance
}

template <class Message>
std::string problem_of_name(const Message& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (message.requester == 0) return "requester is 0: the answer would be nobody's";
  return "";
}

template <class Message>
RelativeRequest read_request(const Message& message) {
  return {message.utime,  message.requester,  message.request_id, message.camera,
          message.map_id, message.keyframe_a, message.keyframe_b};
}

template <class Message>
void write_request(const RelativeRequest& request, Message& message) {
  message.requester = request.requester;
  message.request_id = request.request_id;
  message.camera = request.camera;
  message.map_id = request.map_id;
  message.keyframe_a = request.a;
  message.keyframe_b = request.b;
}

}  // namespace

relative_request_t to_message(const RelativeRequest& request) {
  relative_request_t message;
  message.utime = request.time_us;
  write_request(request, message);
  return message;
}

relative_t to_message(const RelativeAnswer& answer) {
  relative_t message;
  message.utime = answer.time_us;
  write_request(answer.request, message);
  message.server_epoch = answer.origin.server_epoch;
  message.map_epoch = answer.map_epoch;
  message.map_seq = answer.map_seq;
  message.reason = static_cast<std::int16_t>(answer.reason);
  write_pose(answer.view.a_from_b, message.position, message.quaternion);
  write_covariance(answer.view.covariance, message.covariance);
  return message;
}

Decoded<RelativeRequest> decode_relative_request(Bytes bytes) {
  using Result = Decoded<RelativeRequest>;
  const auto decoded = decode_checked<relative_request_t>(bytes, scan_request);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  if (std::string problem = problem_of_name(decoded.value); !problem.empty())
    return Result::refuse(Reason::kMalformedMessage, problem);
  Result result;
  result.value = read_request(decoded.value);
  return result;
}

Decoded<RelativeAnswer> decode_relative(Bytes bytes) {
  using Result = Decoded<RelativeAnswer>;
  const auto decoded = decode_checked<relative_t>(bytes, scan_answer);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  const relative_t& message = decoded.value;
  if (std::string problem = problem_of_name(message); !problem.empty())
    return Result::refuse(Reason::kMalformedMessage, problem);
  if (message.reason == 0 &&
      (!valid_pose(message.position, message.quaternion) || !all_finite(message.covariance, 36)))
    return Result::refuse(Reason::kMalformedMessage, "the pose or its covariance is none");
  Result result;
  RelativeAnswer& answer = result.value;
  answer.time_us = message.utime;
  answer.origin = {message.server_epoch, message.camera};
  answer.request = read_request(message);
  answer.map_epoch = message.map_epoch;
  answer.map_seq = message.map_seq;
  answer.reason = static_cast<Reason>(message.reason);
  answer.view.a_from_b = read_pose(message.position, message.quaternion);
  answer.view.covariance = read_covariance(message.covariance);
  return result;
}

}  // namespace eifmap
