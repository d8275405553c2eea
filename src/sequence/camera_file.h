// Calibrations as files.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/camera.h"
#include "geometry/rigid3.h"

namespace eifmap {

struct CameraFile {
  Camera camera;
  std::string problem;  // "" or which file, line and value, and what was wanted
};

// By its name. *.yaml, *.yml: camera_info as ROS writes it, or what OpenCV's calibration leaves
// (image_width, image_height, camera_matrix, distortion_coefficients). Else calib.json: width,
// height, fx, fy, cx, cy (px), model ("pinhole", "radial_tangential", "fisheye"; none: by the
// distortion) and distortion (k1 k2 p1 p2 k3, of a fisheye k1 k2 k3 k4, OpenCV's orders; all zero,
// or none: a pinhole). Keys that are not known are passed over.
CameraFile read_camera(const std::filesystem::path& file);

// The sensor.yaml of a EuRoC MAV camera: its calibration, and where it sits on the body.
struct SensorFile {
  Camera camera;
  Rigid3 body_from_camera;  // T_BS
  std::string problem;
};
SensorFile read_sensor(const std::filesystem::path& file);

}  // namespace eifmap
