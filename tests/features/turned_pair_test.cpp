// Pairs of views of which one is turned in the image's plane.
#include <gtest/gtest.h>

#include <numbers>

#include "features/extractor.h"
#include "features/images.h"
#include "features/matcher.h"

namespace eifmap {
namespace {

constexpr int kWidth = 360, kHeight = 320;
constexpr double kPi = std::numbers::pi;

Eigen::Matrix3d turn_about_centre(double angle) {
  Eigen::Matrix3d centre = Eigen::Matrix3d::Identity(), turn = Eigen::Matrix3d::Identity();
  centre(0, 2) = 0.5 * (kWidth - 1);
  centre(1, 2) = 0.5 * (kHeight - 1);
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(angle).toRotationMatrix();
  return centre * turn * centre.inverse();
}

FeatureFrame frame_of(const cv::Mat& image, ExtractorKind kind) {
  FeatureOptions options;
  options.extractor = kind;
  options.max_features = 500;
  Features features = FeatureExtractor(options).extract(image, {});
  FeatureFrame frame;
  frame.keypoints = std::move(features.keypoints);
  frame.descriptors = std::move(features.descriptors);
  return frame;
}

struct Figures {
  int matches = 0, right = 0;
  int turned = 0;  // right ones whose angle has turned with the image, to 10 degrees
};

Figures match_turned(double angle, ExtractorKind kind) {
  const testing::Texture texture(5);
  const Eigen::Matrix3d a_from_b = turn_about_centre(-angle);
  const FeatureFrame a =
      frame_of(testing::view(texture, kWidth, kHeight, Eigen::Matrix3d::Identity(), 1.5, 1), kind);
  const FeatureFrame b = frame_of(testing::view(texture, kWidth, kHeight, a_from_b, 1.5, 2), kind);
  Figures figures;
  for (const int sign : {-1, 1})
    for (const Match& m : match(features_of_sign(a, sign), features_of_sign(b, sign), {})) {
      const Keypoint& k = a.keypoints[static_cast<std::size_t>(m.a)];
      const Keypoint& q = b.keypoints[static_cast<std::size_t>(m.b)];
      const Eigen::Vector2d p = (a_from_b * Eigen::Vector3d(q.u, q.v, 1)).hnormalized();
      ++figures.matches;
      if (std::hypot(p.x() - k.u, p.y() - k.v) > 2) continue;
      ++figures.right;
      figures.turned += std::abs(std::remainder(q.angle - k.angle - angle, 2 * kPi)) < kPi / 18;
    }
  return figures;
}

class Oriented : public ::testing::TestWithParam<ExtractorKind> {};

TEST_P(Oriented, FeaturesMatchHoweverTheImageIsTurned) {
  for (const int degrees : {0, 20, 45, 90, 130, 180, -75}) {
    const Figures figures = match_turned(degrees * kPi / 180, GetParam());
    EXPECT_GT(figures.right, 120) << degrees;
    EXPECT_GT(figures.right, 0.9 * figures.matches) << degrees;
    EXPECT_GT(figures.turned, 0.8 * figures.right) << degrees;
  }
}

INSTANTIATE_TEST_SUITE_P(Extractors, Oriented,
                         ::testing::Values(ExtractorKind::kSurfOriented, ExtractorKind::kSift));

TEST(Upright, FeaturesMatchWhileTheImageIsAboutLevel) {
  EXPECT_GT(match_turned(0.15, ExtractorKind::kSurfUpright).right, 120);
  EXPECT_LT(match_turned(1, ExtractorKind::kSurfUpright).right, 10);
}

}  // namespace
}  // namespace eifmap
