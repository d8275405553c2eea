// Calibrations in the YAML of others; read_camera() and read_sensor() are what to call.
#pragma once

#include "sequence/camera_file.h"

namespace eifmap {

CameraFile read_camera_yaml(const std::filesystem::path& file);

}  // namespace eifmap
