#include "features/box_hessian.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "features/images.h"

namespace eifmap {
namespace {

// The filters of Bay et al. 2008, fig. 2, drawn pixel by pixel: the weight at an offset.
int weight_xx(int lobe, int dx, int dy) {
  if (std::abs(dy) > lobe - 1 || std::abs(dx) > filter_margin(lobe)) return 0;
  return std::abs(dx) <= lobe / 2 ? -2 : 1;
}

int weight_xy(int lobe, int dx, int dy) {
  if (dx == 0 || dy == 0 || std::abs(dx) > lobe || std::abs(dy) > lobe) return 0;
  return (dx > 0) == (dy > 0) ? 1 : -1;
}

BoxHessian brute_force(const cv::Mat& image, int x, int y, int lobe) {
  int xx = 0, yy = 0, xy = 0;
  const int margin = filter_margin(lobe);
  for (int dy = -margin; dy <= margin; ++dy)
    for (int dx = -margin; dx <= margin; ++dx) {
      const int pixel = image.at<std::uint8_t>(y + dy, x + dx);
      xx += weight_xx(lobe, dx, dy) * pixel;
      yy += weight_xx(lobe, dy, dx) * pixel;
      xy += weight_xy(lobe, dx, dy) * pixel;
    }
  const float scale = 1.0f / (255.0f * static_cast<float>(filter_side(lobe) * filter_side(lobe)));
  return {static_cast<float>(xx) * scale, static_cast<float>(yy) * scale,
          static_cast<float>(xy) * scale};
}

TEST(BoxHessian, IsTheBruteForceFilter) {
  const cv::Mat image = testing::random_image(70, 64, 1);
  const IntegralImage integral(image);
  for (const int lobe : {1, 3, 5, 7, 9, 13, 17}) {
    const int margin = filter_margin(lobe);
    std::mt19937 random(static_cast<unsigned>(lobe));
    for (int trial = 0; trial < 50; ++trial) {
      const auto pick = [&](int size) {
        return margin + static_cast<int>(random() % static_cast<unsigned>(size - 2 * margin));
      };
      const int x = pick(image.cols), y = pick(image.rows);
      const BoxHessian expected = brute_force(image, x, y, lobe);
      const BoxHessian hessian = box_hessian_at(integral, x, y, lobe);
      ASSERT_EQ(hessian.xx, expected.xx) << "lobe " << lobe << " at " << x << ' ' << y;
      ASSERT_EQ(hessian.yy, expected.yy);
      ASSERT_EQ(hessian.xy, expected.xy);
      if (expected.determinant() > 0) {
        ASSERT_EQ(blob_sign_at(integral, x, y, lobe), expected.trace() < 0 ? -1 : 1);
      }
    }
  }
}

TEST(BoxHessian, RowsAreBitForBitThePoints) {
  const IntegralImage integral(testing::random_image(93, 64, 2));
  HessianRow row;
  std::vector<float> determinants(93);
  for (const int lobe : {1, 3, 9, 17}) {
    const int margin = filter_margin(lobe);
    for (const int y : {margin, 31, 63 - margin}) {
      std::fill(determinants.begin(), determinants.end(), -1.0f);
      row.compute(integral, y, lobe, determinants.data());
      for (int x = 0; x < 93; ++x) {
        const bool fits = x >= margin && x < 93 - margin;
        ASSERT_EQ(determinants[static_cast<std::size_t>(x)],
                  fits ? box_hessian_at(integral, x, y, lobe).determinant() : 0.0f)
            << "lobe " << lobe << " at " << x << ' ' << y;
      }
    }
  }
}

TEST(BoxHessian, TraceTellsBrightFromDark) {
  cv::Mat image(41, 41, CV_8UC1, cv::Scalar(100));
  image(cv::Rect(17, 17, 7, 7)) = cv::Scalar(200);
  EXPECT_LT(box_hessian_at(IntegralImage(image), 20, 20, 5).trace(), 0);
  image(cv::Rect(17, 17, 7, 7)) = cv::Scalar(20);
  EXPECT_GT(box_hessian_at(IntegralImage(image), 20, 20, 5).trace(), 0);
}

}  // namespace
}  // namespace eifmap
