// What a server may say, by its run (epoch), map and number.
#pragma once

#include "convert/map_message.h"
#include "convert/pose_message.h"
#include "convert/status_message.h"

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

inline MapPart part(std::int64_t epoch, std::int64_t map_id, std::int64_t base_seq) {
  MapPart part;
  part.origin = {epoch, "cam"};
  part.update.map_id = map_id;
  part.update.base_seq = base_seq;
  part.update.seq = base_seq + 1;
  return part;
}

inline LandmarkView landmark(std::int64_t id, std::int64_t anchor, double depth) {
  LandmarkView landmark;
  landmark.id = id;
  landmark.anchor = anchor;
  landmark.position_in_anchor = {0.1, -0.2, depth};
  landmark.laplacian_sign = id % 2 == 0 ? 1 : -1;
  landmark.num_observations = 3;
  return landmark;
}

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
