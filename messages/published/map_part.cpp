#include "published/map_part.h"

#include <algorithm>
#include <cmath>

#include "wire/channel.h"
#include "wire/layout.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr std::size_t kKeyframeBytes = 2 * 8 + 7 * 8 + 21 * 4;
constexpr std::size_t kLandmarkBytes = 2 * 8 + 3 * 4 + 6 * 4 + 1;
constexpr std::size_t kRemovedBytes = 8;
constexpr std::size_t kObservationBytes = 2 * 8 + 2 * 4;

void scan(LayoutScanner& in) {
  in.skip(7 * 8 + 2 * 4);  // utime to digest, part, num_parts
  in.string("camera", kMaxText);
  in.array("keyframes", in.count("num_keyframes", kMaxEntries), kKeyframeBytes);
  in.array("landmarks", in.count("num_landmarks", kMaxEntries), kLandmarkBytes);
  in.array("removed", in.count("num_removed", kMaxEntries), kRemovedBytes);
  in.array("observations", in.count("num_observations", kMaxEntries), kObservationBytes);
}

void set_counts(map_part_t& part) {
  part.num_keyframes = static_cast<std::int32_t>(part.keyframes.size());
  part.num_landmarks = static_cast<std::int32_t>(part.landmarks.size());
  part.num_removed = static_cast<std::int32_t>(part.removed.size());
  part.num_observations = static_cast<std::int32_t>(part.observations.size());
}

// Fills parts one after the other.
class Splitter {
 public:
  Splitter(const map_part_t& empty, std::size_t max_bytes)
      : empty_(empty),
        room_in_empty_(max_bytes - static_cast<std::size_t>(empty.getEncodedSize())) {
    begin_part();
  }

  template <class Entry>
  void add(const std::vector<Entry>& entries, std::vector<Entry> map_part_t::*list,
           std::size_t entry_bytes) {
    for (const Entry& entry : entries) {
      if (room_ < entry_bytes) begin_part();
      (parts_.back().*list).push_back(entry);
      room_ -= entry_bytes;
    }
  }

  std::vector<map_part_t> finish() {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      parts_[i].part = static_cast<std::int32_t>(i);
      parts_[i].num_parts = static_cast<std::int32_t>(parts_.size());
      set_counts(parts_[i]);
    }
    return std::move(parts_);
  }

 private:
  void begin_part() {
    parts_.push_back(empty_);
    room_ = room_in_empty_;
  }

  map_part_t empty_;
  std::size_t room_in_empty_;
  std::size_t room_ = 0;
  std::vector<map_part_t> parts_;
};

template <class Entry>
void append_all(const std::vector<Entry>& from, std::vector<Entry>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

// The upper triangle of a symmetric N x N matrix, row by row: all NaN says unknown, anything else
// must be finite, with variances on the diagonal.
bool valid_covariance(const float* triangle, std::size_t n) {
  const std::size_t size = n * (n + 1) / 2;
  if (std::all_of(triangle, triangle + size, [](float x) { return std::isnan(x); })) return true;
  if (!all_finite(triangle, size)) return false;
  for (std::size_t row = 0, at = 0; row < n; at += n - row, ++row)
    if (triangle[at] < 0) return false;
  return true;
}

std::string entry_problem(const map_part_t& part) {
  for (const keyframe_t& k : part.keyframes)
    if (!all_finite(k.position, 3) || !valid_quaternion(k.quaternion) || !valid_time(k.utime) ||
        !valid_covariance(k.covariance, 6))
      return "keyframe " + std::to_string(k.id) + " has no valid pose, time or covariance";
  for (const landmark_t& l : part.landmarks)
    if (!all_finite(l.position, 3) || (l.laplacian_sign != 1 && l.laplacian_sign != -1) ||
        !valid_covariance(l.covariance, 3))
      return "landmark " + std::to_string(l.id) + " has no valid position, covariance or sign";
  for (const observation_t& o : part.observations)
    if (std::isinf(o.u) || std::isinf(o.v) || std::isnan(o.u) != std::isnan(o.v))
      return "an observation of landmark " + std::to_string(o.landmark) + " is not finite";
  return "";
}

std::string problem(const map_part_t& part) {
  if (!valid_camera_name(part.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(part.utime)) return "utime is " + std::to_string(part.utime);
  if (part.num_parts < 1 || part.num_parts > kMaxParts || part.part < 0 ||
      part.part >= part.num_parts)
    return "part " + std::to_string(part.part) + " of " + std::to_string(part.num_parts);
  if (part.seq < 1 || part.seq > kMaxSeq || (part.base_seq != -1 && part.base_seq != part.seq - 1))
    return "an update from seq " + std::to_string(part.base_seq) + " to " +
           std::to_string(part.seq);
  return entry_problem(part);
}

}  // namespace

std::vector<map_part_t> split(const map_part_t& update, std::size_t max_part_bytes) {
  if (max_part_bytes < kMinPartBytes)
    throw std::invalid_argument("max_part_bytes: must be at least " +
                                std::to_string(kMinPartBytes));
  map_part_t empty = update;
  empty.keyframes.clear();
  empty.landmarks.clear();
  empty.removed.clear();
  empty.observations.clear();
  set_counts(empty);
  Splitter splitter(empty, max_part_bytes);
  splitter.add(update.keyframes, &map_part_t::keyframes, kKeyframeBytes);
  splitter.add(update.landmarks, &map_part_t::landmarks, kLandmarkBytes);
  splitter.add(update.removed, &map_part_t::removed, kRemovedBytes);
  splitter.add(update.observations, &map_part_t::observations, kObservationBytes);
  return splitter.finish();
}

void append(const map_part_t& part, map_part_t& whole) {
  append_all(part.keyframes, whole.keyframes);
  append_all(part.landmarks, whole.landmarks);
  append_all(part.removed, whole.removed);
  append_all(part.observations, whole.observations);
  set_counts(whole);
}

Decoded<map_part_t> decode_map_part(Bytes bytes) {
  return decode_checked<map_part_t>(bytes, scan, problem);
}

}  // namespace eifmap
