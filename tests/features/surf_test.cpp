#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <stdexcept>
#include <tuple>

#include "features/extractor.h"
#include "features/images.h"
#include "features/matcher.h"
#include "features/same_features.h"

namespace eifmap {
namespace {

using testing::same;

cv::Mat textured(int width, int height, unsigned seed, double contrast = 1) {
  const testing::Texture texture(seed);
  return testing::render(
      width, height, [&](double x, double y) { return 128 + contrast * (texture(x, y) - 128); });
}

Features extract(const cv::Mat& image, FeatureOptions options = {}) {
  options.extractor = ExtractorKind::kSurfUpright;
  return FeatureExtractor(options).extract(image, {});
}

TEST(Surf, FeaturesAreWhatTheFrameSays) {
  FeatureOptions options;
  options.max_features = 400;
  const cv::Mat image = textured(320, 240, 1);
  const Features features = extract(image, options);
  ASSERT_EQ(features.keypoints.size(), 400u);
  ASSERT_EQ(features.descriptors.size(), 400u * kDescriptorSize);
  int bright = 0;
  for (const Keypoint& k : features.keypoints) {
    EXPECT_GE(k.u, 0);
    EXPECT_LE(k.u, 319);
    EXPECT_GE(k.v, 0);
    EXPECT_LE(k.v, 239);
    EXPECT_GT(k.sigma_px, 0.05f);
    EXPECT_LT(k.sigma_px, 5);
    EXPECT_GE(k.scale, 1);
    EXPECT_GT(k.response, 0);
    EXPECT_EQ(k.angle, 0);
    EXPECT_EQ(std::abs(k.laplacian_sign), 1);
    bright += k.laplacian_sign < 0;
  }
  EXPECT_GT(bright, 100);
  EXPECT_LT(bright, 300);
}

TEST(Surf, OrderIsResponseThenPlace) {
  const Features features = extract(textured(320, 240, 2));
  for (std::size_t i = 1; i < features.keypoints.size(); ++i) {
    const Keypoint &a = features.keypoints[i - 1], &b = features.keypoints[i];
    EXPECT_LE(std::tuple(-a.response, a.v, a.u), std::tuple(-b.response, b.v, b.u));
  }
}

TEST(Surf, NoBlobTwice) {
  const Features features = extract(textured(320, 240, 3));
  std::set<std::tuple<long, long, long>> places;
  for (const Keypoint& k : features.keypoints)
    EXPECT_TRUE(places
                    .emplace(std::lround(20 * k.u), std::lround(20 * k.v),
                             std::lround(20 * std::log(k.scale)))
                    .second);
}

TEST(Surf, DescriptorsAreUnitVectorsOfBytes) {
  const Features features = extract(textured(320, 240, 4));
  ASSERT_FALSE(features.keypoints.empty());
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const std::int8_t* row = &features.descriptors[i * kDescriptorSize];
    double squares = 0;
    for (int k = 0; k < kDescriptorSize; ++k) {
      const double x = row[k];
      EXPECT_GE(x, -127);
      EXPECT_LE(x, 127);
      squares += x * x;
      // Sums of absolute values: at odd places, and no smaller than the plain sums before them.
      if (k % 2 == 1) {
        EXPECT_GE(x + 1, std::abs(int{row[k - 1]}));
      }
    }
    EXPECT_NEAR(std::sqrt(squares), 254, 6);
  }
}

TEST(Surf, SameImageSameBytes) {
  const cv::Mat image = textured(320, 240, 5);
  FeatureOptions options;
  options.extractor = ExtractorKind::kSurfUpright;
  FeatureExtractor extractor(options);
  const Features first = extractor.extract(image, {});
  extractor.extract(textured(200, 300, 6), {});  // another image in between leaves no trace
  EXPECT_TRUE(same(first, extractor.extract(image, {})));
  EXPECT_TRUE(same(first, extract(image.clone())));
}

TEST(Surf, AViewIntoALargerImageIsAnImage) {
  const cv::Mat image = textured(320, 240, 7);
  const cv::Mat part = image(cv::Rect(31, 17, 200, 180));
  EXPECT_TRUE(same(extract(part), extract(part.clone())));
}

TEST(Surf, FaintTextureGivesItsOwnFeatures) {
  const std::size_t plain = extract(textured(320, 240, 8)).keypoints.size();
  const std::size_t faint = extract(textured(320, 240, 8, 0.15)).keypoints.size();
  EXPECT_GT(plain, 300u);
  EXPECT_GT(faint, plain / 2);
}

TEST(Surf, FlatImagesHaveNone) {
  EXPECT_TRUE(extract(cv::Mat(100, 100, CV_8UC1, cv::Scalar(77))).keypoints.empty());
  EXPECT_TRUE(extract(cv::Mat(32, 32, CV_8UC1, cv::Scalar(0))).keypoints.empty());
}

TEST(Surf, SurvivesNoiseAndExtremeShapes) {
  FeatureOptions options;
  for (const int octaves : {1, 3, 6})
    for (const int step : {1, 2, 4}) {
      options.surf.octaves = octaves;
      options.surf.sampling_step = step;
      EXPECT_NO_THROW(extract(testing::random_image(32, 32, 1), options));
      EXPECT_NO_THROW(extract(testing::random_image(33, 500, 2), options));
      EXPECT_NO_THROW(extract(testing::random_image(501, 35, 3), options));
    }
}

TEST(Surf, RefusesOtherImages) {
  EXPECT_THROW(extract(cv::Mat()), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat(100, 100, CV_8UC3)), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat(100, 100, CV_16UC1)), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat(31, 100, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(extract(cv::Mat(100, 31, CV_8UC1)), std::invalid_argument);
}

TEST(FeatureOptions, NameWhatIsWrong) {
  EXPECT_EQ(FeatureOptions().problem(), "");
  const auto expect_problem = [](const char* field, auto change) {
    FeatureOptions options;
    change(options);
    EXPECT_NE(options.problem().find(field), std::string::npos) << options.problem();
    EXPECT_THROW(FeatureExtractor{options}, std::invalid_argument);
  };
  expect_problem("max_features", [](FeatureOptions& o) { o.max_features = 0; });
  expect_problem("max_features", [](FeatureOptions& o) { o.max_features = 1 << 30; });
  expect_problem("octaves", [](FeatureOptions& o) { o.surf.octaves = 0; });
  expect_problem("octaves", [](FeatureOptions& o) { o.surf.octaves = 7; });
  expect_problem("sampling_step", [](FeatureOptions& o) { o.surf.sampling_step = 3; });
  expect_problem("min_response", [](FeatureOptions& o) { o.surf.min_response = -1; });
  expect_problem("min_response", [](FeatureOptions& o) { o.surf.min_response = std::nan(""); });
}

}  // namespace
}  // namespace eifmap
