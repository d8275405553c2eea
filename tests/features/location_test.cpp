// Where features are said to be, against where they are.
#include <gtest/gtest.h>

#include "features/extractor.h"
#include "features/images.h"
#include "features/pair_figures.h"

namespace eifmap {
namespace {

struct Case {
  double sigma;  // px
  double u, v;
  int sign;
};

Features extract(const cv::Mat& image, ExtractorKind kind) {
  FeatureOptions options;
  options.extractor = kind;
  return FeatureExtractor(options).extract(image, {});
}

class FindsABlob : public ::testing::TestWithParam<Case> {};

TEST_P(FindsABlob, WhereItIs) {
  const auto [sigma, u, v, sign] = GetParam();
  const double height = sign < 0 ? 120 : -120;
  const cv::Mat image =
      testing::render(160, 150, [&, u = u, v = v, sigma = sigma](double x, double y) {
        const double r = std::hypot(x - u, y - v) / sigma;
        return 128 + height * std::exp(-0.5 * r * r);
      });
  for (const ExtractorKind kind : {ExtractorKind::kSurfUpright, ExtractorKind::kSift}) {
    // Steps from sample to sample without arriving at some places of the smallest.
    if (kind == ExtractorKind::kSift && sigma < 2) continue;
    const Features features = extract(image, kind);
    ASSERT_FALSE(features.keypoints.empty());
    const Keypoint& best = features.keypoints.front();
    EXPECT_NEAR(best.u, u, 0.06);
    EXPECT_NEAR(best.v, v, 0.06);
    EXPECT_NEAR(best.scale / sigma, 1, 0.05);
    EXPECT_EQ(best.laplacian_sign, sign);
  }
}

INSTANTIATE_TEST_SUITE_P(Blobs, FindsABlob,
                         ::testing::Values(Case{1.6, 70.0, 80.0, -1}, Case{1.6, 70.5, 80.25, 1},
                                           Case{2.1, 81.37, 74.81, -1}, Case{3.0, 80.71, 70.13, 1},
                                           Case{4.4, 79.25, 73.5, -1}, Case{6.0, 83.62, 75.33, 1},
                                           Case{8.0, 80.9, 72.4, -1}, Case{11.0, 78.45, 76.85, 1},
                                           Case{2.5, 50.5, 99.5, 1}, Case{2.5, 50.5, 99.5, -1}));

FeatureFrame frame_of(const cv::Mat& image, ExtractorKind kind) {
  Features features = extract(image, kind);
  FeatureFrame frame;
  frame.keypoints = std::move(features.keypoints);
  frame.descriptors = std::move(features.descriptors);
  return frame;
}

class Pair : public ::testing::TestWithParam<ExtractorKind> {};

TEST_P(Pair, OfKnownHomographyIsFoundAgain) {
  constexpr int kWidth = 400, kHeight = 300;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const double angle = 0.1 * uniform(random), zoom = 1 + 0.1 * uniform(random);
    Eigen::Matrix3d a_from_b, centre = Eigen::Matrix3d::Identity();
    a_from_b << zoom * std::cos(angle), -zoom * std::sin(angle), 8 * uniform(random),
        zoom * std::sin(angle), zoom * std::cos(angle), 8 * uniform(random), 1e-4 * uniform(random),
        1e-4 * uniform(random), 1;
    centre(0, 2) = 0.5 * kWidth;
    centre(1, 2) = 0.5 * kHeight;
    a_from_b = centre * a_from_b * centre.inverse();
    const testing::Texture texture(seed);
    const FeatureFrame a = frame_of(
        testing::view(texture, kWidth, kHeight, Eigen::Matrix3d::Identity(), 1.5, 2 * seed),
        GetParam());
    const FeatureFrame b =
        frame_of(testing::view(texture, kWidth, kHeight, a_from_b, 1.5, 2 * seed + 1), GetParam());
    const testing::PairFigures figures = testing::compare(
        a.keypoints, b.keypoints, testing::match_signs(a, b), a_from_b.inverse(), kWidth, kHeight);
    ::testing::Test::RecordProperty("rms_" + std::to_string(seed), std::to_string(figures.rms()));
    EXPECT_GT(figures.repeated, 0.6 * figures.visible) << figures.visible << " visible";
    EXPECT_GT(figures.matches, 250);
    EXPECT_GT(figures.right, 0.95 * figures.matches) << figures.matches << " matches";
    EXPECT_LT(figures.rms(), 0.17);
    EXPECT_GT(figures.whitened_rms(), 0.3);
    EXPECT_LT(figures.whitened_rms(), 1.2);
  }
}

INSTANTIATE_TEST_SUITE_P(Extractors, Pair,
                         ::testing::Values(ExtractorKind::kSurfUpright,
                                           ExtractorKind::kSurfOriented, ExtractorKind::kSift));

}  // namespace
}  // namespace eifmap
