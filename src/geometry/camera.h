// Camera models: pixel <-> direction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

namespace eifmap {

// The wire's values.
enum class CameraModel : std::int16_t { kPinhole = 0, kRadialTangential = 1, kFisheye = 2 };

// A calibrated camera. Pixel coordinates: the centre of the top-left pixel is (0, 0).
struct Camera {
  int width = 0, height = 0;  // px
  CameraModel model = CameraModel::kPinhole;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  std::array<double, 5> distortion{};     // k1 k2 p1 p2 k3, OpenCV's order

  // "" when usable, else what is wrong, which value, and what would be right.
  std::string problem() const;

  // A hash of all fields above, never 0: what frames name as their calibration_id.
  std::int64_t id() const;

  // Raw pixel -> normalized image coordinates (x/z, y/z), distortion taken off.
  Eigen::Vector2d normalized_from_pixel(const Eigen::Vector2d& pixel) const;

  // Normalized image coordinates -> raw pixel.
  Eigen::Vector2d pixel_from_normalized(const Eigen::Vector2d& normalized) const;

  // One pixel in normalized coordinates: 1 / mean focal length.
  double radians_per_pixel() const { return 2 / (fx + fy); }
};

}  // namespace eifmap
