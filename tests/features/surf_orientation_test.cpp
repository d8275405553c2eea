#include "features/surf_orientation.h"

#include <gtest/gtest.h>

#include <numbers>

#include "features/images.h"

namespace eifmap {
namespace {

constexpr double kPi = std::numbers::pi;

double turned_by(double a, double b) {
  return std::remainder(a - b, 2 * kPi);
}

TEST(SurfOrientation, IsWhereTheImageGetsBrighter) {
  for (int degrees = -175; degrees <= 180; degrees += 5) {
    const double angle = degrees * kPi / 180;
    const cv::Mat image = testing::render(100, 90, [angle](double x, double y) {
      return 128 + std::cos(angle) * (x - 50) + std::sin(angle) * (y - 45);
    });
    EXPECT_NEAR(turned_by(surf_orientation(IntegralImage(image), 50.3f, 44.6f, 2.1f), angle), 0,
                0.02)
        << degrees;
  }
}

TEST(SurfOrientation, TurnsWithTheImage) {
  int right = 0, all = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const testing::Texture texture(seed);
    const auto orientation = [&texture](double angle) {
      const cv::Mat image = testing::render(100, 100, [&](double x, double y) {
        const Eigen::Vector2d p = Eigen::Rotation2Dd(-angle) * Eigen::Vector2d(x - 50, y - 50);
        return texture(p.x(), p.y());
      });
      return surf_orientation(IntegralImage(image), 50, 50, 2.5f);
    };
    const double upright = orientation(0);
    for (const double angle : {0.4, 1.3, 2.9, -2.2}) {
      ++all;
      right += std::abs(turned_by(orientation(angle) - angle, upright)) < 0.15;
    }
  }
  EXPECT_GT(right, 0.75 * all) << "of " << all;
}

TEST(SurfOrientation, OfNothingIsZero) {
  const cv::Mat image(90, 100, CV_8UC1, cv::Scalar(77));
  EXPECT_EQ(surf_orientation(IntegralImage(image), 50, 45, 3), 0);
}

}  // namespace
}  // namespace eifmap
