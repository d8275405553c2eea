// Time for the map.
#pragma once

#include <chrono>
#include <thread>

#include "server/camera_mapper.h"

namespace eifmap {

// Until no keyframe's job runs beside. The thread of the keyframes is niced: on a busy machine it
// has to be waited for.
inline void let_keyframe_in(CameraMapper& mapper) {
  while (mapper.maps_beside()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    mapper.adopt_keyframe(false);
  }
}

}  // namespace eifmap
