// The extractor that follows the camera's roll.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "features/extractor.h"
#include "features/images.h"
#include "features/matcher.h"
#include "features/same_features.h"

namespace eifmap {
namespace {

using testing::same;

constexpr int kWidth = 256, kHeight = 224;
constexpr double kDegree = std::numbers::pi / 180;

Camera camera() {
  Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = 240;
  camera.cx = 0.5 * (kWidth - 1);
  camera.cy = 0.5 * (kHeight - 1);
  return camera;
}

// What the camera sees of a wall when it is rolled, which turns the image about the principal
// point.
cv::Mat rolled(double roll, unsigned noise_seed) {
  const testing::Texture texture(9);
  const Camera c = camera();
  Eigen::Matrix3d centre = Eigen::Matrix3d::Identity(), turn = Eigen::Matrix3d::Identity();
  centre(0, 2) = c.cx;
  centre(1, 2) = c.cy;
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-roll).toRotationMatrix();
  return testing::view(texture, kWidth, kHeight, centre * turn * centre.inverse(), 1.5, noise_seed);
}

FeatureExtractor extractor(ExtractorKind kind) {
  FeatureOptions options;
  options.extractor = kind;
  options.max_features = 300;
  return FeatureExtractor(options);
}

int matches(const Features& a, const Features& b) {
  FeatureFrame x, y;
  x.keypoints = a.keypoints;
  x.descriptors = a.descriptors;
  y.keypoints = b.keypoints;
  y.descriptors = b.descriptors;
  int number = 0;
  for (const int sign : {-1, 1})
    number +=
        static_cast<int>(match(features_of_sign(x, sign), features_of_sign(y, sign), {}).size());
  return number;
}

double difference(double a, double b) {
  return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

TEST(Levelled, ALevelCameraGetsUprightFeaturesBitForBit) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  FeatureExtractor upright = extractor(ExtractorKind::kSurfUpright);
  EXPECT_EQ(levelled.id(), upright.id());
  unsigned seed = 1;
  for (const double degrees : {0.0, 3.0, 9.0, 5.0, -2.0, -9.0, 0.0}) {
    const cv::Mat image = rolled(degrees * kDegree, ++seed);
    EXPECT_TRUE(same(levelled.extract(image, camera()), upright.extract(image, camera())))
        << degrees;
    EXPECT_LT(difference(levelled.roll(), degrees * kDegree), 0.3 * kDegree) << degrees;
    EXPECT_TRUE(levelled.roll_is_sure());
  }
}

TEST(Levelled, FeaturesMatchTheFirstImagesAllAroundTheCircleAndBack) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  const Features first = levelled.extract(rolled(0, 1), camera());
  const auto step_to = [&](int degrees) {
    const Features features = levelled.extract(rolled(degrees * kDegree, 2), camera());
    EXPECT_LT(difference(levelled.roll(), degrees * kDegree), kDegree) << degrees;
    EXPECT_GT(matches(first, features), 70) << degrees;
    // All of the image is described in one frame, and that is at most 11 degrees from level.
    for (const Keypoint& k : features.keypoints) {
      EXPECT_EQ(k.angle, features.keypoints.front().angle);
      EXPECT_LT(difference(k.angle, degrees * kDegree), 11.5 * kDegree);
    }
  };
  for (int degrees = 15; degrees <= 360; degrees += 15) step_to(degrees);
  for (int degrees = 315; degrees >= 0; degrees -= 45) step_to(degrees);
}

TEST(Levelled, TheAngleIsContinuousAcrossTheBand) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  levelled.extract(rolled(0, 1), camera());
  double last = 0;
  for (int degrees = 1; degrees <= 22; ++degrees) {
    const Features features = levelled.extract(rolled(-degrees * kDegree, 2), camera());
    const double angle = features.keypoints.front().angle;
    EXPECT_LT(std::abs(angle - last), 4 * kDegree) << degrees;
    last = angle;
  }
  EXPECT_NEAR(last, -22 * kDegree, 1.5 * kDegree);
}

TEST(Levelled, ASuddenTurnIsSeen) {
  for (const int degrees : {50, -95, 180}) {
    FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
    const Features first = levelled.extract(rolled(0, 1), camera());
    const Features turned = levelled.extract(rolled(degrees * kDegree, 2), camera());
    EXPECT_LT(difference(levelled.roll(), degrees * kDegree), kDegree);
    EXPECT_GT(matches(first, turned), 70);
  }
}

TEST(Levelled, KeepsTheRollWhereThereIsNothingToSee) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  const Features first = levelled.extract(rolled(0, 1), camera());
  levelled.extract(rolled(20 * kDegree, 2), camera());
  const double roll = levelled.roll();
  for (const cv::Mat& blind : {cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(0)),
                               testing::random_image(kWidth, kHeight, 5)}) {
    levelled.extract(blind, camera());
    EXPECT_FALSE(levelled.roll_is_sure());
    EXPECT_EQ(levelled.roll(), roll);
  }
  const Features after = levelled.extract(rolled(40 * kDegree, 3), camera());
  EXPECT_TRUE(levelled.roll_is_sure());
  EXPECT_LT(difference(levelled.roll(), 40 * kDegree), kDegree);
  EXPECT_GT(matches(first, after), 70);
}

// Of a scene that never comes back, the next one is followed, from the roll that was.
TEST(Levelled, GoesOnAfterACut) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  levelled.extract(rolled(30 * kDegree, 1), camera());
  levelled.extract(rolled(50 * kDegree, 1), camera());
  const double roll = levelled.roll();
  const testing::Texture other(10);
  const cv::Mat image = testing::view(other, kWidth, kHeight, Eigen::Matrix3d::Identity(), 1.5, 4);
  for (int i = 0; i < 15; ++i) levelled.extract(image, camera());
  EXPECT_TRUE(levelled.roll_is_sure());
  EXPECT_LT(difference(levelled.roll(), roll), 0.1 * kDegree);
}

// How a camera was held before it was carried through the dark says little of how it is held now.
TEST(Levelled, IsLevelAgainAfterALongDark) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  levelled.extract(rolled(0, 1), camera());
  for (const double degrees : {10., 20., 30., 40.})
    levelled.extract(rolled(degrees * kDegree, 1), camera());
  ASSERT_LT(difference(levelled.roll(), 40 * kDegree), kDegree);
  const cv::Mat dark = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  const testing::Texture other(10);
  const cv::Mat image = testing::view(other, kWidth, kHeight, Eigen::Matrix3d::Identity(), 1.5, 4);
  for (int i = 0; i < 5; ++i) levelled.extract(dark, camera());
  levelled.extract(image, camera());
  EXPECT_LT(difference(levelled.roll(), 40 * kDegree), kDegree) << "a short dark";
  for (int i = 0; i < 30; ++i) levelled.extract(dark, camera());
  levelled.extract(image, camera());
  EXPECT_LT(difference(levelled.roll(), 0), kDegree) << "a long dark";
  levelled.extract(image, camera());
  EXPECT_TRUE(levelled.roll_is_sure());
}

// But of the same view, whichever way it is turned, the roll is known.
TEST(Levelled, KnowsTheLastViewAfterALongDark) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  for (const double degrees : {0., 10., 20., 30., 40.})
    levelled.extract(rolled(degrees * kDegree, 1), camera());
  for (int i = 0; i < 40; ++i) levelled.extract(cv::Mat::zeros(kHeight, kWidth, CV_8UC1), camera());
  levelled.extract(rolled(80 * kDegree, 1), camera());
  EXPECT_TRUE(levelled.roll_is_sure());
  EXPECT_LT(difference(levelled.roll(), 80 * kDegree), kDegree);
}

// Down is nowhere in the image of a camera that looks along it: level is what it was on the way.
TEST(Levelled, LookingStraightDownIsNoReasonToTurn) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  const testing::Texture texture(11);
  const Camera c = camera();
  for (int degrees = 0; degrees <= 100; degrees += 5) {
    // A cylinder of texture about the camera's u axis.
    const cv::Mat image = testing::render(kWidth, kHeight, [&](double u, double v) {
      const Eigen::Vector3d ray((u - c.cx) / c.fx, (v - c.cy) / c.fy, 1);
      const double height = std::atan2(ray.y(), ray.z()) + degrees * kDegree;
      return texture(240 * ray.x() / std::hypot(ray.y(), ray.z()), 240 * height);
    });
    levelled.extract(image, c);
    EXPECT_TRUE(levelled.roll_is_sure()) << degrees;
    EXPECT_LT(std::abs(levelled.roll()), 5 * kDegree) << degrees;
  }
}

// Rolling a camera turns its image about the axis whatever the lens does along the radius.
TEST(Levelled, LeavesOutWhatAFisheyeSeesTooFarFromTheAxis) {
  Camera fisheye = camera();
  fisheye.model = CameraModel::kFisheye;
  fisheye.fx = fisheye.fy = 100;
  ASSERT_EQ(fisheye.problem(), "");
  ASSERT_FALSE(fisheye.normalized_from_pixel({0, 0}).allFinite());
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  levelled.extract(rolled(0, 1), fisheye);
  for (int degrees = 10; degrees <= 40; degrees += 10) {
    levelled.extract(rolled(degrees * kDegree, 2), fisheye);
    EXPECT_TRUE(levelled.roll_is_sure()) << degrees;
    EXPECT_LT(difference(levelled.roll(), degrees * kDegree), 2 * kDegree) << degrees;
  }
}

TEST(Levelled, SameImagesSameBytes) {
  FeatureExtractor a = extractor(ExtractorKind::kAuto), b = extractor(ExtractorKind::kAuto);
  for (const int degrees : {0, 15, 40, 70}) {
    const cv::Mat image = rolled(degrees * kDegree, 1);
    EXPECT_TRUE(same(a.extract(image, camera()), b.extract(image, camera())));
  }
}

TEST(Levelled, NeedsACamera) {
  FeatureExtractor levelled = extractor(ExtractorKind::kAuto);
  EXPECT_THROW(levelled.extract(rolled(0, 1), Camera{}), std::invalid_argument);
}

TEST(RollOptions, NameWhatIsWrong) {
  EXPECT_EQ(RollOptions().problem(), "");
  for (const double wrong : {-1.0, 46.0, std::nan("")})
    EXPECT_TRUE(RollOptions{wrong}.problem().starts_with("roll.dead_band_deg"));
}

}  // namespace
}  // namespace eifmap
