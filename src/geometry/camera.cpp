#include "geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "geometry/lens.h"

namespace eifmap {
namespace {

Eigen::Vector2d distort(const Camera& camera, const Eigen::Vector2d& n,
                        Eigen::Matrix2d* jacobian = nullptr) {
  if (camera.model == CameraModel::kRadialTangential)
    return lens::distort_radial_tangential(camera.distortion, n, jacobian);
  if (camera.model == CameraModel::kFisheye)
    return lens::distort_fisheye(camera.distortion, n, jacobian);
  if (jacobian) jacobian->setIdentity();
  return n;
}

std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& distorted) {
  if (camera.model == CameraModel::kRadialTangential)
    return lens::undistort_radial_tangential(camera.distortion, distorted);
  if (camera.model == CameraModel::kFisheye)
    return lens::undistort_fisheye(camera.distortion, distorted);
  if (!(distorted.norm() <= std::tan(kMaxViewAngle))) return std::nullopt;
  return distorted;
}

std::string describe(const char* what, double value, const char* wanted) {
  return std::string("camera: ") + what + " is " + std::to_string(value) + ", wanted " + wanted;
}

// The farthest of the image's corners from the axis, in distorted coordinates.
double corner_radius(const Camera& camera) {
  const double x = std::max(camera.cx, camera.width - 1 - camera.cx) / camera.fx;
  const double y = std::max(camera.cy, camera.height - 1 - camera.cy) / camera.fy;
  return std::hypot(x, y);
}

// A fisheye's radius must grow up to the image's corner, or to the last angle in use.
std::string fisheye_problem(const Camera& camera) {
  if (camera.distortion[4] != 0)
    return describe("distortion[4]", camera.distortion[4], "0: a fisheye has k1 k2 k3 k4");
  const Eigen::Vector2d corner(corner_radius(camera), 0);
  const auto at_corner = lens::undistort_fisheye(camera.distortion, corner);
  const double end = at_corner ? std::atan(at_corner->norm()) : kMaxViewAngle;
  constexpr int kSteps = 200;
  for (int i = 1; i <= kSteps; ++i) {
    const double theta = end * i / kSteps;
    if (!(lens::fisheye_slope(camera.distortion, theta) > 0))
      return describe("the angle at which the fisheye's image folds over", theta * 180 / M_PI,
                      "none inside the image, in degrees; check the coefficients");
  }
  return "";
}

// A lens model that folds over inside the image has no inverse there.
std::string lens_problem(const Camera& camera) {
  if (camera.model == CameraModel::kFisheye) return fisheye_problem(camera);
  for (int row = 0; row <= 8; ++row)
    for (int column = 0; column <= 8; ++column) {
      const Eigen::Vector2d pixel(column * (camera.width - 1) / 8.0,
                                  row * (camera.height - 1) / 8.0);
      const Eigen::Vector2d n = camera.normalized_from_pixel(pixel);
      const double error = (camera.pixel_from_normalized(n) - pixel).norm();
      if (!(error < 0.01))
        return "camera: no ray within 80 degrees of the axis leads to pixel (" +
               std::to_string(pixel.x()) + ", " + std::to_string(pixel.y()) +
               "); check the distortion coefficients' order and the focal length";
    }
  return "";
}

}  // namespace

std::string Camera::problem() const {
  if (width < 16 || width > 16384) return describe("width", width, "16 to 16384 px");
  if (height < 16 || height > 16384) return describe("height", height, "16 to 16384 px");
  if (model != CameraModel::kPinhole && model != CameraModel::kRadialTangential &&
      model != CameraModel::kFisheye)
    return describe("model", static_cast<int>(model),
                    "0 (pinhole), 1 (radial-tangential) or 2 (fisheye)");
  const double largest = std::max(width, height);
  if (!(fx > 0.1 * largest && fx < 100 * largest))
    return describe("fx", fx, "0.1 to 100 times the image's larger side, in px");
  if (!(fy > 0.1 * largest && fy < 100 * largest))
    return describe("fy", fy, "0.1 to 100 times the image's larger side, in px");
  if (!(cx > -width && cx < 2 * width)) return describe("cx", cx, "a column near the image, in px");
  if (!(cy > -height && cy < 2 * height)) return describe("cy", cy, "a row near the image, in px");
  for (double k : distortion)
    if (!std::isfinite(k) || std::abs(k) > 100)
      return describe("a distortion coefficient", k, "a finite number within +-100");
  return lens_problem(*this);
}

std::int64_t Camera::id() const {
  // FNV-1a over the bytes of the fields.
  std::uint64_t hash = 1469598103934665603ull;
  const auto add = [&hash](const auto& value) {
    unsigned char bytes[sizeof(value)];
    std::memcpy(bytes, &value, sizeof(value));
    for (unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211ull;
  };
  add(width), add(height), add(model), add(fx), add(fy), add(cx), add(cy);
  for (double k : distortion) add(k);
  const auto id = static_cast<std::int64_t>(hash >> 1);
  return id == 0 ? 1 : id;
}

Eigen::Vector2d Camera::normalized_from_pixel(const Eigen::Vector2d& pixel) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return undistort(*this, {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy})
      .value_or(Eigen::Vector2d(kNone, kNone));
}

Eigen::Vector2d Camera::pixel_from_normalized(const Eigen::Vector2d& normalized) const {
  const Eigen::Vector2d n = distort(*this, normalized);
  return {fx * n.x() + cx, fy * n.y() + cy};
}

Eigen::Matrix2d Camera::normalized_jacobian(const Eigen::Vector2d& normalized) const {
  Eigen::Matrix2d distorting;
  distort(*this, normalized, &distorting);
  return distorting.inverse() * Eigen::Vector2d(1 / fx, 1 / fy).asDiagonal();
}

double Camera::radians_per_pixel_at(const Eigen::Vector2d& normalized) const {
  Eigen::Matrix2d distorting;
  distort(*this, normalized, &distorting);
  return radians_per_pixel() / std::sqrt(std::abs(distorting.determinant()));
}

Camera camera_of_view(int width, int height, double hfov_deg) {
  if (!(hfov_deg >= kMinHfovDeg && hfov_deg <= kMaxHfovDeg) || width < 1 || height < 1)
    throw std::invalid_argument("camera_of_view: " + std::to_string(width) + "x" +
                                std::to_string(height) + " with " + std::to_string(hfov_deg) +
                                " degrees");
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.5 * width / std::tan(hfov_deg * M_PI / 360);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

}  // namespace eifmap
