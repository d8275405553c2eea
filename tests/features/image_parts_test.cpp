// Features come from all parts of an image that have texture, not from the strongest alone.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "features/extractor.h"
#include "features/images.h"
#include "sequence/image_file.h"

namespace eifmap {
namespace {

constexpr int kColumns = 8, kRows = 6;
constexpr int kEnough = 3;      // features in a part
constexpr double kTexture = 2;  // grey values: mean size of what is 1.5 to 6 px large

// Parts of an image: with texture, and of these, with enough features.
struct Parts {
  int textured = 0, covered = 0;
};

std::array<int, kColumns * kRows> count_features(const cv::Mat& image) {
  FeatureOptions options;
  options.extractor = ExtractorKind::kSurfUpright;
  std::array<int, kColumns * kRows> counts{};
  for (const Keypoint& k : FeatureExtractor(options).extract(image, {}).keypoints) {
    const int column = std::min(kColumns - 1, static_cast<int>(k.u * kColumns / image.cols));
    const int row = std::min(kRows - 1, static_cast<int>(k.v * kRows / image.rows));
    ++counts[static_cast<std::size_t>(row * kColumns + column)];
  }
  return counts;
}

Parts examine(const cv::Mat& image) {
  cv::Mat fine, coarse, texture;
  cv::GaussianBlur(image, fine, {0, 0}, 1.5);
  cv::GaussianBlur(image, coarse, {0, 0}, 6);
  cv::absdiff(fine, coarse, texture);
  const std::array<int, kColumns* kRows> counts = count_features(image);
  Parts parts;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const int width = image.cols / kColumns, height = image.rows / kRows;
      const cv::Rect part(column * width, row * height, width, height);
      if (cv::mean(texture(part))[0] < kTexture) continue;
      ++parts.textured;
      parts.covered += counts[static_cast<std::size_t>(row * kColumns + column)] >= kEnough;
    }
  return parts;
}

TEST(ImageParts, FaintOnesHaveFeaturesBesideStrongOnes) {
  const testing::Texture texture(3);
  const cv::Mat image = testing::render(640, 480, [&](double x, double y) {
    return 128 + (x < 320 ? 1.0 : 0.3) * (texture(x, y) - 128);
  });
  const std::array<int, kColumns* kRows> counts = count_features(image);
  for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_GE(counts[i], kEnough) << "part " << i;
  EXPECT_GT(std::accumulate(counts.begin(), counts.end(), 0), 900);
}

class RecordedParts : public ::testing::TestWithParam<const char*> {};

TEST_P(RecordedParts, HaveFeaturesWhereTheyHaveTexture) {
  const char* shared = std::getenv("EIFMAP_SHARED");
  const std::filesystem::path root = shared
                                         ? std::filesystem::path(shared)
                                         : std::filesystem::path(EIFMAP_SOURCE_DIR) / "../shared";
  const std::filesystem::path folder = root / "data" / GetParam() / "images";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "skipped: no " << folder;
  std::vector<std::filesystem::path> files;
  ASSERT_EQ(list_images(folder, files), "");
  Parts all;
  for (std::size_t i = 0; i < files.size(); i += 20) {
    const GrayImage image = read_gray(files[i]);
    ASSERT_EQ(image.problem, "");
    const Parts parts = examine(image.image);
    EXPECT_GE(parts.covered, 0.7 * parts.textured) << files[i];
    all.textured += parts.textured;
    all.covered += parts.covered;
  }
  RecordProperty("textured", all.textured);
  RecordProperty("covered", all.covered);
  EXPECT_GE(all.covered, 0.85 * all.textured);
}

INSTANTIATE_TEST_SUITE_P(Recordings, RecordedParts,
                         ::testing::Values("kitchen", "kitti00", "living_room"));

}  // namespace
}  // namespace eifmap
