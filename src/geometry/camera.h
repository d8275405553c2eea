// Camera models: pixel <-> direction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

namespace eifmap {

// The wire's values.
enum class CameraModel : std::int16_t { kPinhole = 0, kRadialTangential = 1, kFisheye = 2 };

// Rays further than this from the optical axis are not used: (x/z, y/z) grows without bound towards
// 90 degrees and ends there. Of a lens that sees more, the outer ring of the image is left alone.
inline constexpr double kMaxViewAngle = 80 * M_PI / 180;

// A calibrated camera. Pixel coordinates: the centre of the top-left pixel is (0, 0).
struct Camera {
  int width = 0, height = 0;  // px
  CameraModel model = CameraModel::kPinhole;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  // OpenCV's orders. Radial-tangential: k1 k2 p1 p2 k3. Fisheye (equidistant): k1 k2 k3 k4, then 0.
  std::array<double, 5> distortion{};

  // "" when usable, else what is wrong, which value, and what would be right.
  std::string problem() const;

  // A hash of all fields above, never 0: what frames name as their calibration_id.
  std::int64_t id() const;

  // Raw pixel -> normalized image coordinates (x/z, y/z), distortion taken off, exact to rounding.
  // NaN, both, for a pixel whose ray is beyond kMaxViewAngle.
  Eigen::Vector2d normalized_from_pixel(const Eigen::Vector2d& pixel) const;

  // Normalized image coordinates -> raw pixel.
  Eigen::Vector2d pixel_from_normalized(const Eigen::Vector2d& normalized) const;

  // d(normalized) / d(pixel) at the place with these normalized coordinates.
  Eigen::Matrix2d normalized_jacobian(const Eigen::Vector2d& normalized) const;

  // One pixel in normalized coordinates where the image is not distorted: 1 / mean focal length.
  double radians_per_pixel() const { return 2 / (fx + fy); }

  // One pixel in normalized coordinates at the place with these normalized coordinates: the square
  // root of its area there. All over a pinhole's image the same as radians_per_pixel(); more where
  // a lens squeezes the image.
  double radians_per_pixel_at(const Eigen::Vector2d& normalized) const;
};

// A guess for who has no calibration: a pinhole with square pixels, the axis through the centre of
// the image, and this angle from its left edge to its right one. Throws std::invalid_argument on an
// angle beyond the limits or a size below 1.
inline constexpr double kMinHfovDeg = 10, kMaxHfovDeg = 150;
Camera camera_of_view(int width, int height, double hfov_deg);

}  // namespace eifmap
