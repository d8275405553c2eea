#include "features/integral_image.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "features/images.h"

namespace eifmap {
namespace {

int brute_force_sum(const cv::Mat& image, int x0, int y0, int x1, int y1) {
  int sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += image.at<std::uint8_t>(y, x);
  return sum;
}

void expect_boxes(const cv::Mat& image, unsigned seed) {
  const IntegralImage integral(image);
  ASSERT_EQ(integral.width(), image.cols);
  ASSERT_EQ(integral.height(), image.rows);
  std::mt19937 random(seed);
  for (int trial = 0; trial < 500; ++trial) {
    const auto pick = [&random](int size) {
      return static_cast<int>(random() % static_cast<unsigned>(size + 1));
    };
    const auto [x0, x1] = std::minmax({pick(image.cols), pick(image.cols)});
    const auto [y0, y1] = std::minmax({pick(image.rows), pick(image.rows)});
    ASSERT_EQ(integral.box(x0, y0, x1, y1), brute_force_sum(image, x0, y0, x1, y1));
  }
}

TEST(IntegralImage, BoxesAreBruteForceSums) {
  expect_boxes(testing::random_image(67, 41, 1), 2);
  expect_boxes(testing::random_image(1, 1, 3), 4);
}

TEST(IntegralImage, RowsOfALargerImageMayLieApart) {
  const cv::Mat image = testing::random_image(80, 60, 5);
  expect_boxes(image(cv::Rect(11, 7, 33, 21)), 6);
}

TEST(IntegralImage, BoxesAreRightWhereTheWholeSumOverflows) {
  const cv::Mat white(4200, 4200, CV_8UC1, cv::Scalar(255));  // 4.5e9 > 2^32
  const IntegralImage integral(white);
  EXPECT_EQ(integral.box(4100, 4100, 4200, 4200), 255 * 100 * 100);
  EXPECT_EQ(integral.box(0, 4199, 4200, 4200), 255 * 4200);
}

TEST(IntegralImage, RefusesOtherImages) {
  EXPECT_THROW(IntegralImage(cv::Mat(10, 10, CV_8UC3)), std::invalid_argument);
  EXPECT_THROW(IntegralImage(cv::Mat(10, 10, CV_16UC1)), std::invalid_argument);
  EXPECT_THROW(IntegralImage{cv::Mat()}, std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
