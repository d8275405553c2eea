// What a server may say, by its run (epoch), map and number.
#pragma once

#include "convert/map_message.h"
#include "convert/pose_message.h"
#include "convert/status_message.h"
#include "published/map_part.h"
#include "published/published_map.h"

namespace eifmap::test {

inline PublishedPose pose(std::int64_t epoch, std::int64_t map_id, int i,
                          TrackingState state = TrackingState::kTracking) {
  PublishedPose pose;
  pose.origin = {epoch, "cam"};
  FrameResult& result = pose.result;
  result.time_us = 1000000 + std::int64_t{33333} * i;
  result.map_id = map_id;
  result.state = state;
  result.source = PoseSource::kScaleFit;
  result.map_from_camera = {so3_exp({0.1 * i, 0.2, -0.3}), {i / 3.0, 0.1, -0.5 * i}};
  result.num_matches = 200;
  result.num_inliers = 150;
  return pose;
}

// Base 0: the whole map.
inline MapUpdate update(std::int64_t map_id, std::int64_t base_seq) {
  MapUpdate update;
  update.map_id = map_id;
  update.base_seq = base_seq == 0 ? -1 : base_seq;
  update.seq = base_seq + 1;
  return update;
}

// Seen from three keyframes, which need not be there.
inline void add_landmark(std::int64_t id, std::int64_t anchor, double depth, MapUpdate& update) {
  LandmarkView landmark;
  landmark.id = id;
  landmark.anchor = anchor;
  landmark.position_in_anchor = {0.1, -0.2, depth};
  landmark.laplacian_sign = id % 2 == 0 ? 1 : -1;
  update.landmarks.push_back(landmark);
  for (int keyframe = 0; keyframe < 3; ++keyframe)
    update.observations.push_back({keyframe, id, 1, 2});
}

// Updates with their digests, as a server says them.
class Publishing {
 public:
  std::vector<map_part_t> publish(const MapUpdate& update, std::int64_t epoch,
                                  std::size_t max_part_bytes = 1u << 30) {
    map_part_t message = to_message(update, {epoch, "cam"}, 1000);
    map_.apply(message);
    message.digest = map_.digest();
    return split(message, max_part_bytes);
  }

 private:
  PublishedMap map_;
};

inline status_t status(std::int64_t epoch, std::int8_t state, Reason reason = Reason::kNone) {
  status_t status{};
  status.metres_per_unit = 1;
  status.server_epoch = epoch;
  status.camera = "cam";
  status.state = state;
  status.reason = static_cast<std::int16_t>(reason);
  status.message = reason == Reason::kNone ? "all is well" : "551 of 595 matches";
  status.hint = "move the camera";
  return status;
}

}  // namespace eifmap::test
