#include "features/sift.h"

#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>
#include <set>
#include <tuple>

#include "features/images.h"
#include "features/same_features.h"

namespace eifmap {
namespace {

using testing::same;

cv::Mat textured(unsigned seed) {
  return testing::view(testing::Texture(seed), 320, 240, Eigen::Matrix3d::Identity(), 1.5, seed);
}

TEST(Sift, FeaturesAreWhatTheFrameSays) {
  const Features features = extract_sift(textured(1), {}, 200);
  ASSERT_EQ(features.keypoints.size(), 200u);
  ASSERT_EQ(features.descriptors.size(), 200u * kDescriptorSize);
  int bright = 0;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    EXPECT_GE(k.u, 0);
    EXPECT_LE(k.u, 319.5f);
    EXPECT_GE(k.v, 0);
    EXPECT_LE(k.v, 239.5f);
    EXPECT_GE(k.sigma_px, 0.1f);
    EXPECT_LT(k.sigma_px, 10);
    EXPECT_GT(k.scale, 0);
    EXPECT_EQ(std::abs(k.laplacian_sign), 1);
    bright += k.laplacian_sign < 0;
    if (i > 0) {
      const Keypoint& before = features.keypoints[i - 1];
      EXPECT_LE(std::tuple(-before.response, before.v, before.u),
                std::tuple(-k.response, k.v, k.u));
    }
    double squares = 0;
    for (int n = 0; n < kDescriptorSize; ++n) {
      const double x = features.descriptors[i * kDescriptorSize + static_cast<std::size_t>(n)];
      EXPECT_LE(std::abs(x), 127);
      squares += x * x;
    }
    EXPECT_NEAR(std::sqrt(squares), 254, 6);
  }
  EXPECT_GT(bright, 50);
  EXPECT_LT(bright, 150);
}

// OpenCV alone gives about every sixth blob once for each of its dominant orientations.
TEST(Sift, NoBlobTwice) {
  const Features features = extract_sift(textured(2), {}, 100000);
  ASSERT_GT(features.keypoints.size(), 300u);
  std::set<std::tuple<float, float, float>> places;
  for (const Keypoint& k : features.keypoints)
    EXPECT_TRUE(places.emplace(k.u, k.v, k.scale).second);
}

TEST(Sift, ThreadsChangeNothing) {
  const cv::Mat image = textured(3);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const Features alone = extract_sift(image, {}, 500);
  cv::setNumThreads(2);
  for (int repeat = 0; repeat < 10; ++repeat)
    EXPECT_TRUE(same(alone, extract_sift(image, {}, 500)));
  cv::setNumThreads(threads);
}

TEST(Sift, FlatImagesHaveNone) {
  EXPECT_TRUE(extract_sift(cv::Mat(100, 100, CV_8UC1, cv::Scalar(77)), {}, 100).keypoints.empty());
}

TEST(Sift, SurvivesNoiseAndExtremeShapes) {
  for (const auto& [width, height] : {std::pair(32, 32), std::pair(33, 500), std::pair(501, 35)})
    for (const Keypoint& k :
         extract_sift(testing::random_image(width, height, 4), {}, 1000).keypoints) {
      EXPECT_GE(k.u, -0.5f);
      EXPECT_GE(k.v, -0.5f);
      EXPECT_LE(k.u, static_cast<float>(width) - 0.5f);
      EXPECT_LE(k.v, static_cast<float>(height) - 0.5f);
    }
}

TEST(SiftOptions, NameWhatIsWrong) {
  EXPECT_EQ(SiftOptions().problem(), "");
  const auto problem = [](auto change) {
    SiftOptions options;
    change(options);
    return options.problem();
  };
  EXPECT_TRUE(problem([](SiftOptions& o) { o.octave_layers = 0; }).starts_with("sift.octave"));
  EXPECT_TRUE(problem([](SiftOptions& o) { o.contrast_threshold = -1; }).starts_with("sift.contr"));
  EXPECT_TRUE(problem([](SiftOptions& o) { o.edge_threshold = 0; }).starts_with("sift.edge"));
}

}  // namespace
}  // namespace eifmap
