#include "geometry/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <set>

namespace eifmap {
namespace {

Camera pinhole() {
  return {640, 480, CameraModel::kPinhole, 500, 510, 319.5, 239.5, {}};
}

// A wide lens: corners at 45 degrees, barrel distortion of a fifth of the radius there.
Camera wide_lens() {
  return {640, 480, CameraModel::kRadialTangential,     400, 400,
          320, 240, {-0.28, 0.07, 0.0002, -0.0003, 0.0}};
}

TEST(Camera, UndistortingUndoesDistortingEverywhere) {
  for (const Camera& camera : {pinhole(), wide_lens()})
    for (double u = 0; u <= camera.width; u += 20)
      for (double v = 0; v <= camera.height; v += 20) {
        const Eigen::Vector2d pixel(u, v);
        const Eigen::Vector2d back =
            camera.pixel_from_normalized(camera.normalized_from_pixel(pixel));
        EXPECT_LT((back - pixel).norm(), 1e-8) << u << ' ' << v;
      }
}

TEST(Camera, DistortsAsOpenCvDoes) {
  const Camera camera = wide_lens();
  const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const std::vector<double> coefficients(camera.distortion.begin(), camera.distortion.end());
  for (double x = -0.8; x <= 0.8; x += 0.2)
    for (double y = -0.6; y <= 0.6; y += 0.2) {
      std::vector<cv::Point2d> pixels;
      cv::projectPoints(std::vector<cv::Point3d>{{x, y, 1}}, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0),
                        k, coefficients, pixels);
      const Eigen::Vector2d ours = camera.pixel_from_normalized({x, y});
      EXPECT_LT((ours - Eigen::Vector2d(pixels[0].x, pixels[0].y)).norm(), 1e-9);
    }
}

TEST(Camera, PinholeIgnoresTheCoefficients) {
  Camera camera = pinhole();
  camera.distortion = {1, 2, 3, 4, 5};
  EXPECT_EQ(camera.normalized_from_pixel({0, 0}), pinhole().normalized_from_pixel({0, 0}));
}

TEST(Camera, ProblemNamesTheFieldThatIsWrong) {
  EXPECT_EQ(pinhole().problem(), "");
  EXPECT_EQ(wide_lens().problem(), "");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto problem = [](auto&& change) {
    Camera camera = wide_lens();
    change(camera);
    return camera.problem();
  };
  EXPECT_NE(problem([](Camera& c) { c.width = -1; }).find("width"), std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.height = 1 << 20; }).find("height"), std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.fx = 0; }).find("fx"), std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.fy = kNan; }).find("fy"), std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.cx = -1e9; }).find("cx"), std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.cy = kNan; }).find("cy"), std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.distortion[4] = kNan; }).find("distortion"),
            std::string::npos);
  EXPECT_NE(problem([](Camera& c) { c.model = static_cast<CameraModel>(3); }).find("model"),
            std::string::npos);
}

TEST(Camera, EveryFieldEntersTheId) {
  std::set<std::int64_t> ids{wide_lens().id()};
  const auto add = [&ids](auto&& change) {
    Camera camera = wide_lens();
    change(camera);
    ids.insert(camera.id());
  };
  add([](Camera& c) { c.width++; });
  add([](Camera& c) { c.height++; });
  add([](Camera& c) { c.model = CameraModel::kPinhole; });
  add([](Camera& c) { c.fx += 1e-9; });
  add([](Camera& c) { c.fy += 1e-9; });
  add([](Camera& c) { c.cx += 1e-9; });
  add([](Camera& c) { c.cy += 1e-9; });
  for (int i = 0; i < 5; ++i) add([i](Camera& c) { c.distortion[i] += 1e-9; });
  EXPECT_EQ(ids.size(), 13u);
  EXPECT_EQ(ids.count(0), 0u);
  EXPECT_EQ(wide_lens().id(), wide_lens().id());
}

TEST(Camera, OfAViewSeesItsEdgesAtThatAngle) {
  for (const double degrees : {10.0, 62.0, 150.0}) {
    const Camera camera = camera_of_view(640, 480, degrees);
    EXPECT_EQ(camera.problem(), "");
    const double left = camera.normalized_from_pixel({-0.5, 239.5}).x();
    const double right = camera.normalized_from_pixel({639.5, 239.5}).x();
    EXPECT_NEAR((std::atan(right) - std::atan(left)) * 180 / M_PI, degrees, 1e-9);
  }
  EXPECT_THROW(camera_of_view(640, 480, 0), std::invalid_argument);
  EXPECT_THROW(camera_of_view(640, 480, 180), std::invalid_argument);
  EXPECT_THROW(camera_of_view(0, 480, 60), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
