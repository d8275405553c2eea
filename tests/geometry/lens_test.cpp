// The lens models through Camera: both ways, derivatives, and what is out of view.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "geometry/camera.h"
#include "support/numeric_jacobian.h"
#include "support/random.h"

namespace eifmap {
namespace {

Camera lens(CameraModel model, double focal, const std::array<double, 5>& k) {
  return {640, 480, model, focal, 1.01 * focal, 321, 237, k};
}

Camera radial_tangential(double focal, const std::array<double, 5>& k) {
  return lens(CameraModel::kRadialTangential, focal, k);
}

Camera fisheye(double focal, const std::array<double, 5>& k) {
  return lens(CameraModel::kFisheye, focal, k);
}

// Lenses as sold, and beyond.
std::vector<Camera> lenses() {
  return {lens(CameraModel::kPinhole, 200, {}),
          radial_tangential(400, {-0.28, 0.07, 0.0002, -0.0003, 0}),
          radial_tangential(300, {-0.3, 0.12, 0, 0, 0.02}),     // strong barrel
          radial_tangential(450, {0.9, 0.5, 0, 0, 0.4}),        // strong pincushion
          radial_tangential(500, {-0.3, 0.1, 0.02, -0.03, 0}),  // badly centred
          radial_tangential(800, {-0.5, 0, 0, 0, 0}),           // folds over outside the image
          fisheye(305, {}),                                     // ideal
          fisheye(285, {-0.013, 0.004, -0.001, 0.0002, 0}),     // 80 degrees to the corner
          fisheye(190, {0.05, -0.02, 0.004, -0.001, 0}),        // sees more than we use
          fisheye(330, {-0.15, 0.02, 0, 0, 0}),                 // strong barrel
          fisheye(500, {0.5, 0.3, 0.2, 0.1, 0}),                // strong pincushion
          fisheye(640, {-0.2, -0.1, 0, 0, 0})};                 // folds over outside the image
}

TEST(Lens, EveryPixelInViewComesBack) {
  int out_of_view = 0;
  for (const Camera& camera : lenses()) {
    ASSERT_EQ(camera.problem(), "");
    for (double u = 0; u < camera.width; u += 7)
      for (double v = 0; v < camera.height; v += 7) {
        const Eigen::Vector2d n = camera.normalized_from_pixel({u, v});
        if (!n.allFinite()) {
          EXPECT_TRUE(std::isnan(n.x()) && std::isnan(n.y()));
          ++out_of_view;
          continue;
        }
        EXPECT_LT((camera.pixel_from_normalized(n) - Eigen::Vector2d(u, v)).norm(), 1e-9);
      }
  }
  EXPECT_GT(out_of_view, 0);
}

// The other way round: the ray found is the one that made the pixel, not another branch's.
TEST(Lens, EveryRayInTheImageComesBack) {
  test::Random random(1);
  for (const Camera& camera : lenses())
    for (int k = 0; k < 500; ++k) {
      const Eigen::Vector2d pixel(random.uniform(0, 639), random.uniform(0, 479));
      const Eigen::Vector2d end = camera.normalized_from_pixel(pixel);
      if (!end.allFinite()) continue;
      // Everything from the axis to there is in the image too, seen through the same branch.
      const Eigen::Vector2d n = random.uniform() * end;
      const Eigen::Vector2d back = camera.normalized_from_pixel(camera.pixel_from_normalized(n));
      EXPECT_LT((back - n).norm(), 1e-9 * (1 + n.squaredNorm()));
    }
}

// Coefficients at random, some of them no lens at all: what problem() lets through must come back.
TEST(Lens, WhateverPassesTheCheckCanBeUndone) {
  test::Random random(2);
  int usable = 0, refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<double, 5> k{};
    for (int i = 0; i < 4; ++i) k[i] = std::pow(10, random.uniform(-4, 0.3)) * random.normal();
    const double focal = random.uniform(150, 700);
    if (trial % 2) k[2] *= 0.05, k[3] *= 0.05;
    const Camera camera = trial % 2 ? radial_tangential(focal, k) : fisheye(focal, k);
    if (!camera.problem().empty()) {
      ++refused;
      continue;
    }
    ++usable;
    for (int p = 0; p < 50; ++p) {
      const Eigen::Vector2d pixel(random.uniform(0, 639), random.uniform(0, 479));
      const Eigen::Vector2d n = camera.normalized_from_pixel(pixel);
      if (!n.allFinite()) {
        EXPECT_EQ(camera.model, CameraModel::kFisheye) << camera.problem();
        continue;
      }
      EXPECT_LT((camera.pixel_from_normalized(n) - pixel).norm(), 1e-6);
      EXPECT_GT(camera.normalized_jacobian(n).determinant(), 0) << "folded over";
    }
  }
  EXPECT_GT(usable, 200);
  EXPECT_GT(refused, 200);
}

TEST(Lens, JacobianIsTheDerivative) {
  test::Random random(3);
  for (const Camera& camera : lenses())
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector2d pixel(random.uniform(0, 639), random.uniform(0, 479));
      const Eigen::Vector2d n = camera.normalized_from_pixel(pixel);
      if (!(n.norm() < 5)) continue;
      const auto numeric = test::numeric_jacobian<2, 2>(
          [&](const Eigen::Vector2d& d) { return camera.normalized_from_pixel(pixel + d); }, 1e-4);
      EXPECT_LT(test::relative_difference(camera.normalized_jacobian(n), numeric), 1e-6);
    }
}

TEST(Lens, JacobianAtTheAxisIsThePinholes) {
  for (const Camera& camera :
       {fisheye(300, {0.1, 0.2, 0, 0, 0}), radial_tangential(300, {0.1, 0.2, 0, 0, 0})}) {
    const Eigen::Matrix2d expected = Eigen::Vector2d(1 / camera.fx, 1 / camera.fy).asDiagonal();
    EXPECT_LT((camera.normalized_jacobian({0, 0}) - expected).norm(), 1e-12);
    EXPECT_LT((camera.normalized_jacobian({1e-10, 0}) - expected).norm(), 1e-12);
    EXPECT_LT((camera.normalized_jacobian({1e-8, 0}) - expected).norm(), 1e-9);
  }
}

TEST(Lens, APixelsSizeFollowsTheImage) {
  const Camera pinhole = lens(CameraModel::kPinhole, 200, {});
  for (double u = 0; u < 640; u += 50)
    EXPECT_EQ(pinhole.radians_per_pixel_at(pinhole.normalized_from_pixel({u, 100})),
              pinhole.radians_per_pixel());
  const Camera ideal = fisheye(300, {});
  EXPECT_EQ(ideal.radians_per_pixel_at({0, 0}), ideal.radians_per_pixel());
  // At 60 degrees: 1 / cos^2 outwards, tan / angle around.
  const double expected = std::sqrt(4 * std::sqrt(3.0) / (M_PI / 3));
  EXPECT_NEAR(ideal.radians_per_pixel_at({0, std::sqrt(3.0)}) / ideal.radians_per_pixel(), expected,
              1e-12);
}

TEST(Lens, FisheyeDistortsAsOpenCvDoes) {
  const Camera camera = fisheye(300, {-0.03, 0.02, -0.01, 0.002, 0});
  const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const cv::Vec4d coefficients(-0.03, 0.02, -0.01, 0.002);
  for (double x = -4; x <= 4; x += 0.8)
    for (double y = -4; y <= 4; y += 0.8) {
      std::vector<cv::Point2d> pixels;
      cv::fisheye::projectPoints(std::vector<cv::Point3d>{{x, y, 1}}, pixels, cv::Vec3d(0, 0, 0),
                                 cv::Vec3d(0, 0, 0), k, coefficients);
      const Eigen::Vector2d ours = camera.pixel_from_normalized({x, y});
      EXPECT_LT((ours - Eigen::Vector2d(pixels[0].x, pixels[0].y)).norm(), 1e-9);
    }
}

// An ideal fisheye tells the angle of a pixel by its radius.
TEST(Lens, BeyondTheLargestAngleThereIsNothing) {
  const Camera camera = fisheye(150, {});
  EXPECT_EQ(camera.problem(), "");  // its corners see 150 degrees from the axis
  const double limit = 150 * kMaxViewAngle;
  EXPECT_TRUE(camera.normalized_from_pixel({321 + limit - 0.01, 237}).allFinite());
  EXPECT_FALSE(camera.normalized_from_pixel({321 + limit + 0.01, 237}).allFinite());
  EXPECT_FALSE(camera.normalized_from_pixel({0, 0}).allFinite());
}

TEST(Lens, AFoldInsideTheImageIsAProblem) {
  // Radius theta - 0.5 theta^3 is largest at 46.8 degrees.
  EXPECT_NE(fisheye(305, {-0.5, 0, 0, 0, 0}).problem().find("folds over is 46.8"),
            std::string::npos)
      << fisheye(305, {-0.5, 0, 0, 0, 0}).problem();
  EXPECT_EQ(fisheye(900, {-0.5, 0, 0, 0, 0}).problem(), "");  // the corners are at 29 degrees
  EXPECT_NE(fisheye(305, {0, 0, 0, 0, 0.1}).problem().find("k1 k2 k3 k4"), std::string::npos);
  EXPECT_NE(radial_tangential(400, {-0.5, 0, 0, 0, 0}).problem().find("no ray"), std::string::npos);
}

}  // namespace
}  // namespace eifmap
