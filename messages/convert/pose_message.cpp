#include "convert/pose_message.h"

#include "convert/pose_fields.h"
#include "convert/scale_fields.h"
#include "wire/channel.h"
#include "wire/layouts.h"

namespace eifmap {
namespace {

std::string problem(const pose_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (message.state < pose_t::STATE_WAITING || message.state > pose_t::STATE_LOST)
    return "state is " + std::to_string(message.state);
  if (message.source < pose_t::SOURCE_NONE || message.source > pose_t::SOURCE_START_SET)
    return "source is " + std::to_string(message.source);
  if (message.covariance_status < pose_t::COV_NONE ||
      message.covariance_status > pose_t::COV_OPTIMISTIC)
    return "covariance_status is " + std::to_string(message.covariance_status);
  if (!valid_pose(message.position, message.quaternion) ||
      !valid_pose(message.reference_position, message.reference_quaternion))
    return "the pose is not finite or not a rotation";
  if (!all_finite(message.covariance, 36)) return "the covariance is not finite";
  if (!valid_scale(message)) return "the scale is no scale";
  if (message.num_matches < 0 || message.num_inliers < 0) return "a negative count of matches";
  return "";
}

}  // namespace

pose_t to_message(const PublishedPose& pose) {
  const FrameResult& result = pose.result;
  pose_t message;
  message.utime = result.time_us;
  message.publisher = result.publisher;
  message.input_seq = result.seq;
  message.server_epoch = pose.origin.server_epoch;
  message.map_id = result.map_id;
  message.map_epoch = result.map_epoch;
  message.map_seq = result.map_seq;
  message.camera = pose.origin.camera;
  message.state = static_cast<std::int8_t>(result.state);
  message.source = static_cast<std::int8_t>(result.source);
  message.covariance_status = static_cast<std::int8_t>(result.covariance_status);
  message.reason = static_cast<std::int16_t>(result.reason);
  write_pose(result.map_from_camera, message.position, message.quaternion);
  write_covariance(result.covariance, message.covariance);
  message.reference_keyframe = result.reference_keyframe;
  write_pose(result.reference_from_camera, message.reference_position,
             message.reference_quaternion);
  write_scale(result.scale, message);
  message.num_matches = result.num_matches;
  message.num_inliers = result.num_inliers;
  return message;
}

Decoded<PublishedPose> decode_pose(Bytes bytes) {
  using Result = Decoded<PublishedPose>;
  const Decoded<pose_t> decoded = decode_checked<pose_t>(bytes, scan_pose);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  const pose_t& message = decoded.value;
  if (std::string found = problem(message); !found.empty())
    return Result::refuse(Reason::kMalformedMessage, found);

  Result decoded_pose;
  decoded_pose.value.origin = {message.server_epoch, message.camera};
  FrameResult& result = decoded_pose.value.result;
  result.time_us = message.utime;
  result.publisher = message.publisher;
  result.seq = message.input_seq;
  result.map_id = message.map_id;
  result.map_epoch = message.map_epoch;
  result.map_seq = message.map_seq;
  result.state = static_cast<TrackingState>(message.state);
  result.source = static_cast<PoseSource>(message.source);
  result.covariance_status = static_cast<CovarianceStatus>(message.covariance_status);
  result.reason = static_cast<Reason>(message.reason);
  result.map_from_camera = read_pose(message.position, message.quaternion);
  result.covariance = read_covariance(message.covariance);
  result.reference_keyframe = message.reference_keyframe;
  result.reference_from_camera =
      read_pose(message.reference_position, message.reference_quaternion);
  result.scale = read_scale(message);
  result.num_matches = message.num_matches;
  result.num_inliers = message.num_inliers;
  return decoded_pose;
}

}  // namespace eifmap
