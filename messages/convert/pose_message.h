// The pose of a frame: pose_t <-> FrameResult.
#pragma once

#include <eifmap/pose_t.hpp>

#include "map_view.h"
#include "wire/bytes.h"

namespace eifmap {

// Who says so: one run of a server, one camera.
struct Origin {
  std::int64_t server_epoch = 0;  // us since the Unix epoch, the server's start
  std::string camera;
};

struct PublishedPose {
  Origin origin;
  FrameResult result;  // without detail, rejected, map_updated: they do not travel
};

pose_t to_message(const PublishedPose& pose);

// Refuses with kMalformedMessage: sizes, name, time, unknown codes, a pose that is not finite or
// not a rotation, a scale that is none.
Decoded<PublishedPose> decode_pose(Bytes bytes);

}  // namespace eifmap
