#include "features/gaussian_derivatives.h"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "features/images.h"

namespace eifmap {
namespace {

// n-th derivative of exp(-x^2 / (2 s^2)).
double gaussian_derivative(int n, double x, double s) {
  double hermite = 1, before = 0;
  const double t = x / s;
  for (int k = 0; k < n; ++k) {
    const double next = t * hermite - k * before;
    before = hermite;
    hermite = next;
  }
  return (n % 2 == 0 ? 1 : -1) * hermite * std::exp(-0.5 * t * t) / std::pow(s, n);
}

struct Case {
  double blob, sigma, dx, dy;  // px
};

class GaussianDerivativesOf : public ::testing::TestWithParam<Case> {};

// A Gaussian blob smoothed by a Gaussian is a wider one, whose derivatives are known.
TEST_P(GaussianDerivativesOf, AGaussianBlob) {
  const double blob = GetParam().blob, sigma = GetParam().sigma;
  const double dx = GetParam().dx, dy = GetParam().dy;
  constexpr double kCentreU = 90.3, kCentreV = 85.8, kHeight = 180;
  const cv::Mat image = testing::render(180, 170, [&](double x, double y) {
    const double r = std::hypot(x - kCentreU, y - kCentreV) / blob;
    return 30 + kHeight * std::exp(-0.5 * r * r);
  });
  const GaussianDerivatives derivatives =
      gaussian_derivatives(ImagePyramid(image, 5), kCentreU + dx, kCentreV + dy, sigma);
  const double wide = std::hypot(blob, sigma);
  const double gain = kHeight / 255 * blob * blob / (wide * wide);
  for (int j = 0; j < GaussianDerivatives::kOrders; ++j)
    for (int i = 0; i + j < GaussianDerivatives::kOrders; ++i) {
      if (i + j == 0) continue;
      const double expected = gain * std::pow(sigma, i + j) * gaussian_derivative(i, dx, wide) *
                              gaussian_derivative(j, dy, wide);
      // Beyond the fourth order only the speed of Newton's method depends on them.
      const double tolerance = gain * (i + j <= 4 ? 0.008 : 0.06);
      EXPECT_NEAR(derivatives.of[j][i], expected, tolerance) << "to u " << i << ", to v " << j;
    }
}

INSTANTIATE_TEST_SUITE_P(Scales, GaussianDerivativesOf,
                         ::testing::Values(Case{3, 1.3, 0, 0}, Case{3, 2, 0.4, -0.7},
                                           Case{3, 2.45, 1.1, 0.9}, Case{4, 2.55, 1.1, 0.9},
                                           Case{6, 4.9, -2.2, 1.3}, Case{6, 5.1, -2.2, 1.3},
                                           Case{9, 9.5, 3.1, 2.6}, Case{8, 11, -4, -3.3}));

TEST(ImagePyramid, RefusesOtherImages) {
  EXPECT_THROW(ImagePyramid(cv::Mat(40, 40, CV_8UC3), 3), std::invalid_argument);
  EXPECT_THROW(ImagePyramid(cv::Mat(), 3), std::invalid_argument);
}

TEST(ImagePyramid, LevelsKeepAConstantAndStopWhenTooSmall) {
  const ImagePyramid pyramid(cv::Mat(9, 13, CV_8UC1, cv::Scalar(51)), 10);
  EXPECT_EQ(pyramid.levels(), 4);
  for (int k = 0; k < pyramid.levels(); ++k)
    for (int y = -ImagePyramid::kBorder; y < pyramid.height(k) + ImagePyramid::kBorder; ++y)
      for (int x = -ImagePyramid::kBorder; x < pyramid.width(k) + ImagePyramid::kBorder; ++x)
        ASSERT_NEAR(pyramid.row(k, y)[x], 0.2, 1e-6);
}

}  // namespace
}  // namespace eifmap
