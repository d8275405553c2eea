#include "geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace eifmap {
namespace {

// Radial-tangential distortion of normalized coordinates (Brown; OpenCV's order of coefficients).
Eigen::Vector2d distort(const std::array<double, 5>& k, const Eigen::Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

bool has_distortion(const Camera& camera) {
  return camera.model == CameraModel::kRadialTangential;
}

std::string describe(const char* what, double value, const char* wanted) {
  return std::string("camera: ") + what + " is " + std::to_string(value) + ", wanted " + wanted;
}

}  // namespace

std::string Camera::problem() const {
  if (width < 16 || width > 16384) return describe("width", width, "16 to 16384 px");
  if (height < 16 || height > 16384) return describe("height", height, "16 to 16384 px");
  if (model != CameraModel::kPinhole && model != CameraModel::kRadialTangential)
    return describe("model", static_cast<int>(model), "0 (pinhole) or 1 (radial-tangential)");
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
  // A lens model that folds over inside the image has no inverse there.
  for (int row = 0; row <= 8; ++row)
    for (int column = 0; column <= 8; ++column) {
      const Eigen::Vector2d pixel(column * (width - 1) / 8.0, row * (height - 1) / 8.0);
      const double error = (pixel_from_normalized(normalized_from_pixel(pixel)) - pixel).norm();
      if (!(error < 0.01))
        return describe("the distortion's error after its inverse", error,
                        "0 px everywhere in the image; check the coefficients' order");
    }
  return "";
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
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!has_distortion(*this)) return distorted;
  // Newton with a numeric Jacobian: converges where the plain fixed-point iteration does not
  // (corners of wide lenses), and the step stays exact to rounding.
  Eigen::Vector2d n = distorted;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d error = distort(distortion, n) - distorted;
    if (error.squaredNorm() < 1e-24) break;
    constexpr double h = 1e-6;
    Eigen::Matrix2d jacobian;
    for (int c = 0; c < 2; ++c) {
      const Eigen::Vector2d step = h * Eigen::Vector2d::Unit(c);
      jacobian.col(c) = (distort(distortion, n + step) - distort(distortion, n - step)) / (2 * h);
    }
    if (std::abs(jacobian.determinant()) < 1e-9) break;
    n -= jacobian.inverse() * error;
  }
  return n;
}

Eigen::Vector2d Camera::pixel_from_normalized(const Eigen::Vector2d& normalized) const {
  const Eigen::Vector2d n = has_distortion(*this) ? distort(distortion, normalized) : normalized;
  return {fx * n.x() + cx, fy * n.y() + cy};
}

}  // namespace eifmap
