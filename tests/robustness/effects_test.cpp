#include "robustness/effects.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "support/random.h"

namespace eifmap::test {
namespace {

// Smooth enough for a JPEG, with something everywhere.
cv::Mat some_image(int width = 120, int height = 90) {
  cv::RNG random(7);
  cv::Mat image(height, width, CV_8U);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {}, 2);
  cv::normalize(image, image, 30, 190, cv::NORM_MINMAX);
  return image;
}

double rms(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(static_cast<double>(a.total()));
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Effects, AWorseJpegIsSmallerAndFurtherOff) {
  const cv::Mat image = some_image();
  const auto good = as_jpeg(image, 80), bad = as_jpeg(image, 50);
  EXPECT_LT(bad.size(), good.size());
  const double off = rms(image, cv::imdecode(good, cv::IMREAD_UNCHANGED)),
               further_off = rms(image, cv::imdecode(bad, cv::IMREAD_UNCHANGED));
  EXPECT_GT(off, 0.1);
  EXPECT_GT(further_off, 1.2 * off);
  EXPECT_LT(further_off, 10);
}

TEST(Effects, APixelOfHalfTheSizeIsTheMeanOfFour) {
  const cv::Mat image = some_image(121, 91), half = half_size(image);
  ASSERT_EQ(half.size(), cv::Size(60, 45));
  for (const cv::Point p : {cv::Point(0, 0), cv::Point(13, 29), cv::Point(59, 44)}) {
    const double mean = cv::mean(image(cv::Rect(2 * p.x, 2 * p.y, 2, 2)))[0];
    EXPECT_NEAR(half.at<std::uint8_t>(p), mean, 0.5 + 1e-9) << p;
  }
}

// Where a ray comes down in the half image is where its pixel's place went: the centre of the four
// pixels from (2i, 2k) on is at (2i + 0.5, 2k + 0.5).
TEST(Effects, HalfACameraSeesTheSameRays) {
  Camera camera;
  camera.width = 1241, camera.height = 376;
  camera.model = CameraModel::kRadialTangential;
  camera.fx = 718.8, camera.fy = 700.1, camera.cx = 607.2, camera.cy = 185.2;
  camera.distortion = {-0.28, 0.07, 1e-3, -2e-3, 0};
  const Camera half = half_size(camera);
  EXPECT_EQ(half.problem(), "");
  EXPECT_EQ(half.width, 620);
  EXPECT_EQ(half.height, 188);
  for (const Eigen::Vector2d& ray : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.4, -0.1)}) {
    const Eigen::Vector2d whole = camera.pixel_from_normalized(ray);
    const Eigen::Vector2d expected = (whole - Eigen::Vector2d(0.5, 0.5)) / 2;
    EXPECT_LT((half.pixel_from_normalized(ray) - expected).norm(), 1e-9);
  }
}

TEST(Effects, AGainScalesUpToWhite) {
  const cv::Mat image = (cv::Mat_<std::uint8_t>(1, 3) << 10, 100, 250);
  EXPECT_TRUE(same(with_gain(image, 1.2), (cv::Mat_<std::uint8_t>(1, 3) << 12, 120, 255)));
  EXPECT_TRUE(same(with_gain(image, 0.8), (cv::Mat_<std::uint8_t>(1, 3) << 8, 80, 200)));
}

TEST(Effects, NoiseHasItsSigmaAndNoBias) {
  const cv::Mat image(200, 300, CV_8U, cv::Scalar(120));
  cv::RNG random(3);
  cv::Scalar mean, sigma;
  cv::meanStdDev(with_noise(image, 10, random), mean, sigma);
  EXPECT_NEAR(mean[0], 120, 0.2);
  EXPECT_NEAR(sigma[0], 10, 0.2);
  cv::RNG again(3);
  EXPECT_FALSE(same(with_noise(image, 10, random), with_noise(image, 10, again)));
}

TEST(Effects, NothingButNoiseHasAllGrays) {
  cv::RNG random(3);
  const cv::Mat image = nothing_but_noise({300, 200}, random);
  double least, most;
  cv::minMaxLoc(image, &least, &most);
  EXPECT_EQ(least, 0);
  EXPECT_EQ(most, 255);
  EXPECT_NEAR(cv::mean(image)[0], 127.5, 1.5);
}

TEST(Effects, ShiftedPixelsAreWhereTheyWentAndTheRestIsBlack) {
  const cv::Mat image = some_image();
  for (const cv::Point by : {cv::Point(30, -12), cv::Point(-30, 12), cv::Point(0, 0)}) {
    const cv::Mat moved = shifted(image, by);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const cv::Point from = cv::Point(x, y) - by;
        const bool seen = cv::Rect({}, image.size()).contains(from);
        ASSERT_EQ(moved.at<std::uint8_t>(y, x), seen ? image.at<std::uint8_t>(from) : 0);
      }
  }
  EXPECT_EQ(cv::countNonZero(shifted(image, {500, 0})), 0);
}

TEST(Effects, HalfIsCoveredAndHalfIsNot) {
  const cv::Mat image = some_image();
  for (const Half half : {Half::kLeft, Half::kRight, Half::kTop, Half::kBottom}) {
    const cv::Mat covered = half_covered(image, half, 255), changed = covered != image;
    EXPECT_EQ(cv::countNonZero(changed), static_cast<int>(image.total()) / 2);
    const bool first = half == Half::kLeft || half == Half::kTop;
    EXPECT_EQ(changed.at<std::uint8_t>(0, 0) != 0, first);
    EXPECT_EQ(changed.at<std::uint8_t>(image.rows - 1, image.cols - 1) != 0, !first);
    EXPECT_EQ(changed.at<std::uint8_t>(0, image.cols - 1) != 0,
              half == Half::kRight || half == Half::kTop);
  }
}

}  // namespace
}  // namespace eifmap::test
