// The camera of the simulated worlds.
#pragma once

#include "geometry/camera.h"

namespace eifmap::simulation {

// 640x480, square pixels, no distortion; `focal` in px.
inline Camera vga_camera(double focal) {
  return {640, 480, CameraModel::kPinhole, focal, focal, 319.5, 239.5, {}};
}

}  // namespace eifmap::simulation
