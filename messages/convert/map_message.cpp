#include "convert/map_message.h"

#include <limits>

#include "convert/pose_fields.h"

namespace eifmap {
namespace {

// The upper triangle of a symmetric N x N matrix, row by row.
template <int N>
void write_triangle(const Eigen::Matrix<double, N, N>& matrix, float* out) {
  for (int row = 0; row < N; ++row)
    for (int column = row; column < N; ++column) *out++ = static_cast<float>(matrix(row, column));
}

keyframe_t to_message(const KeyframeView& keyframe) {
  keyframe_t message;
  message.id = keyframe.id;
  message.utime = keyframe.time_us;
  write_pose(keyframe.map_from_camera, message.position, message.quaternion);
  write_triangle<6>(keyframe.covariance, message.covariance);
  return message;
}

landmark_t to_message(const LandmarkView& landmark) {
  landmark_t message;
  message.id = landmark.id;
  message.anchor = landmark.anchor;
  for (int i = 0; i < 3; ++i)
    message.position[i] = static_cast<float>(landmark.position_in_anchor[i]);
  write_triangle<3>(landmark.covariance, message.covariance);
  message.laplacian_sign = static_cast<std::int8_t>(landmark.laplacian_sign);
  return message;
}

observation_t to_message(const ObservationView& observation) {
  observation_t message;
  message.keyframe = observation.keyframe;
  message.landmark = observation.landmark;
  message.u = observation.u;
  message.v = observation.v;
  return message;
}

observation_t gone(const ObservationView& observation) {
  observation_t message = to_message(observation);
  message.u = message.v = std::numeric_limits<float>::quiet_NaN();
  return message;
}

}  // namespace

map_part_t to_message(const MapUpdate& update, const Origin& origin, std::int64_t time_us) {
  map_part_t message{};
  message.utime = time_us;
  message.server_epoch = origin.server_epoch;
  message.map_id = update.map_id;
  message.map_epoch = update.map_epoch;
  message.seq = update.seq;
  message.base_seq = update.base_seq;
  message.num_parts = 1;
  message.camera = origin.camera;
  for (const KeyframeView& k : update.keyframes) message.keyframes.push_back(to_message(k));
  for (const LandmarkView& l : update.landmarks) message.landmarks.push_back(to_message(l));
  message.removed = update.removed_landmarks;
  for (const ObservationView& o : update.observations)
    message.observations.push_back(to_message(o));
  for (const ObservationView& o : update.removed_observations)
    message.observations.push_back(gone(o));
  message.num_keyframes = static_cast<std::int32_t>(message.keyframes.size());
  message.num_landmarks = static_cast<std::int32_t>(message.landmarks.size());
  message.num_removed = static_cast<std::int32_t>(message.removed.size());
  message.num_observations = static_cast<std::int32_t>(message.observations.size());
  return message;
}

}  // namespace eifmap
