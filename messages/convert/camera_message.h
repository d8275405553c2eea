// Calibration: camera_t <-> Camera.
#pragma once

#include <eifmap/camera_t.hpp>

#include "geometry/camera.h"
#include "wire/bytes.h"

namespace eifmap {

struct NamedCamera {
  std::int64_t time_us = 0;
  std::string name;
  Camera camera;
};

camera_t to_message(const NamedCamera& camera);

// Refuses: kMalformedMessage (sizes, name, time), kBadCalibration (numbers, or an id that is
// neither 0 nor camera.id()).
Decoded<NamedCamera> decode_camera(Bytes bytes);

}  // namespace eifmap
