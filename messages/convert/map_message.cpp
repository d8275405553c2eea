#include "convert/map_message.h"

#include <algorithm>

#include "convert/channel.h"
#include "convert/layout.h"
#include "convert/pose_fields.h"

namespace eifmap {
namespace {

constexpr std::size_t kKeyframeBytes = 2 * 8 + 7 * 8 + 21 * 4;
constexpr std::size_t kLandmarkBytes = 2 * 8 + 3 * 4 + 6 * 4 + 1 + 4;
constexpr std::size_t kRemovedBytes = 8;
constexpr std::size_t kObservationBytes = 2 * 8 + 2 * 4;

void scan(LayoutScanner& in) {
  in.skip(6 * 8 + 2 * 4);  // utime to base_seq, part, num_parts
  in.string("camera", kMaxText);
  in.array("keyframes", in.count("num_keyframes", kMaxEntries), kKeyframeBytes);
  in.array("landmarks", in.count("num_landmarks", kMaxEntries), kLandmarkBytes);
  in.array("removed", in.count("num_removed", kMaxEntries), kRemovedBytes);
  in.array("observations", in.count("num_observations", kMaxEntries), kObservationBytes);
}

// Fills parts one after the other.
class Splitter {
 public:
  Splitter(const MapPart& empty, std::size_t max_bytes)
      : empty_(empty),
        room_in_empty_(max_bytes - static_cast<std::size_t>(to_message(empty).getEncodedSize())) {
    begin_part();
  }

  template <class Entry>
  void add(const std::vector<Entry>& entries, std::vector<Entry> MapUpdate::*list,
           std::size_t entry_bytes) {
    for (const Entry& entry : entries) {
      if (room_ < entry_bytes) begin_part();
      (parts_.back().update.*list).push_back(entry);
      room_ -= entry_bytes;
    }
  }

  std::vector<MapPart> finish() {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      parts_[i].part = static_cast<int>(i);
      parts_[i].num_parts = static_cast<int>(parts_.size());
    }
    return std::move(parts_);
  }

 private:
  void begin_part() {
    parts_.push_back(empty_);
    room_ = room_in_empty_;
  }

  MapPart empty_;
  std::size_t room_in_empty_;
  std::size_t room_ = 0;
  std::vector<MapPart> parts_;
};

// The upper triangle of a symmetric N x N matrix, row by row.
template <int N>
void write_triangle(const Eigen::Matrix<double, N, N>& matrix, float* out) {
  for (int row = 0; row < N; ++row)
    for (int column = row; column < N; ++column) *out++ = static_cast<float>(matrix(row, column));
}

template <int N>
Eigen::Matrix<double, N, N> read_triangle(const float* in) {
  Eigen::Matrix<double, N, N> matrix;
  for (int row = 0; row < N; ++row)
    for (int column = row; column < N; ++column) matrix(row, column) = matrix(column, row) = *in++;
  return matrix;
}

// All NaN says unknown; anything else must be finite, with variances on the diagonal.
template <int N>
bool valid_covariance(const float* values) {
  const Eigen::Matrix<double, N, N> covariance = read_triangle<N>(values);
  if (covariance.array().isNaN().all()) return true;
  return covariance.allFinite() && covariance.diagonal().minCoeff() >= 0;
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
  message.num_observations = landmark.num_observations;
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

KeyframeView from_message(const keyframe_t& message) {
  return {message.id, message.utime, read_pose(message.position, message.quaternion),
          read_triangle<6>(message.covariance)};
}

LandmarkView from_message(const landmark_t& message) {
  return {message.id,
          message.anchor,
          {message.position[0], message.position[1], message.position[2]},
          message.laplacian_sign,
          message.num_observations,
          read_triangle<3>(message.covariance)};
}

ObservationView from_message(const observation_t& message) {
  return {message.keyframe, message.landmark, message.u, message.v};
}

template <class From, class To>
void convert_all(const std::vector<From>& from, std::vector<To>& to) {
  to.reserve(from.size());
  for (const From& entry : from) {
    if constexpr (requires { from_message(entry); })
      to.push_back(from_message(entry));
    else
      to.push_back(to_message(entry));
  }
}

std::string entry_problem(const map_part_t& message) {
  for (const keyframe_t& k : message.keyframes)
    if (!valid_pose(k.position, k.quaternion) || !valid_time(k.utime) ||
        !valid_covariance<6>(k.covariance))
      return "keyframe " + std::to_string(k.id) + " has no valid pose, time or covariance";
  for (const landmark_t& l : message.landmarks)
    if (!all_finite(l.position, 3) || (l.laplacian_sign != 1 && l.laplacian_sign != -1) ||
        l.num_observations < 0 || !valid_covariance<3>(l.covariance))
      return "landmark " + std::to_string(l.id) +
             " has no valid position, covariance, sign or count";
  for (const observation_t& o : message.observations)
    if (!std::isfinite(o.u) || !std::isfinite(o.v))
      return "an observation of landmark " + std::to_string(o.landmark) + " is not finite";
  return "";
}

std::string problem(const map_part_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (message.num_parts < 1 || message.num_parts > kMaxParts || message.part < 0 ||
      message.part >= message.num_parts)
    return "part " + std::to_string(message.part) + " of " + std::to_string(message.num_parts);
  if (message.base_seq < -1 || message.seq <= message.base_seq)
    return "an update from seq " + std::to_string(message.base_seq) + " to " +
           std::to_string(message.seq);
  return entry_problem(message);
}

}  // namespace

std::vector<MapPart> split_update(const MapUpdate& update, const Origin& origin,
                                  std::int64_t time_us, std::size_t max_part_bytes) {
  if (max_part_bytes < kMinPartBytes)
    throw std::invalid_argument("max_part_bytes: must be at least " +
                                std::to_string(kMinPartBytes));
  MapPart empty;
  empty.origin = origin;
  empty.time_us = time_us;
  empty.update.map_id = update.map_id;
  empty.update.map_epoch = update.map_epoch;
  empty.update.seq = update.seq;
  empty.update.base_seq = update.base_seq;
  Splitter splitter(empty, max_part_bytes);
  splitter.add(update.keyframes, &MapUpdate::keyframes, kKeyframeBytes);
  splitter.add(update.landmarks, &MapUpdate::landmarks, kLandmarkBytes);
  splitter.add(update.removed_landmarks, &MapUpdate::removed_landmarks, kRemovedBytes);
  splitter.add(update.observations, &MapUpdate::observations, kObservationBytes);
  return splitter.finish();
}

map_part_t to_message(const MapPart& part) {
  const MapUpdate& update = part.update;
  map_part_t message;
  message.utime = part.time_us;
  message.server_epoch = part.origin.server_epoch;
  message.map_id = update.map_id;
  message.map_epoch = update.map_epoch;
  message.seq = update.seq;
  message.base_seq = update.base_seq;
  message.part = part.part;
  message.num_parts = part.num_parts;
  message.camera = part.origin.camera;
  convert_all(update.keyframes, message.keyframes);
  convert_all(update.landmarks, message.landmarks);
  message.removed = update.removed_landmarks;
  convert_all(update.observations, message.observations);
  message.num_keyframes = static_cast<std::int32_t>(message.keyframes.size());
  message.num_landmarks = static_cast<std::int32_t>(message.landmarks.size());
  message.num_removed = static_cast<std::int32_t>(message.removed.size());
  message.num_observations = static_cast<std::int32_t>(message.observations.size());
  return message;
}

Decoded<MapPart> decode_map_part(Bytes bytes) {
  using Result = Decoded<MapPart>;
  const Decoded<map_part_t> decoded = decode_checked<map_part_t>(bytes, scan);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  const map_part_t& message = decoded.value;
  if (std::string found = problem(message); !found.empty())
    return Result::refuse(Reason::kMalformedMessage, found);

  Result result;
  result.value.origin = {message.server_epoch, message.camera};
  result.value.time_us = message.utime;
  result.value.part = message.part;
  result.value.num_parts = message.num_parts;
  MapUpdate& update = result.value.update;
  update.map_id = message.map_id;
  update.map_epoch = message.map_epoch;
  update.seq = message.seq;
  update.base_seq = message.base_seq;
  convert_all(message.keyframes, update.keyframes);
  convert_all(message.landmarks, update.landmarks);
  update.removed_landmarks = message.removed;
  convert_all(message.observations, update.observations);
  return result;
}

}  // namespace eifmap
