#include "features/blob_detector.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "features/box_hessian.h"
#include "features/images.h"

namespace eifmap {
namespace {

constexpr int kStep = 1;

// Against every neighbour, one by one. Of equal ones, the first in the order of levels, rows,
// columns is the maximum.
bool is_maximum(const IntegralImage& integral, int x, int y, int lobe, int lobe_step, int step) {
  const float h = box_hessian_at(integral, x, y, lobe).determinant();
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        if (std::tuple(k, j, i) == std::tuple(0, 0, 0)) continue;
        const float other =
            box_hessian_at(integral, x + i * step, y + j * step, lobe + k * lobe_step)
                .determinant();
        if (std::tuple(k, j, i) < std::tuple(0, 0, 0) ? other >= h : other > h) return false;
      }
  return true;
}

constexpr int kWidth = 174, kHeight = 122;

// Along the axes, neighbours are equal.
cv::Mat symmetric_image() {
  cv::Mat image = testing::random_image(kWidth, kHeight, 7);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      image.at<std::uint8_t>(y, x) =
          image.at<std::uint8_t>(std::min(y, kHeight - 1 - y), std::min(x, kWidth - 1 - x));
  return image;
}

TEST(BlobDetector, FindsTheMaximaAndNoOthers) {
  constexpr float kMin = 1e-4f;
  for (const int octaves : {1, 2, 3}) {
    const IntegralImage integral(symmetric_image());
    const std::vector<BlobCandidate> found = find_blobs(integral, octaves, kStep, kMin);
    std::set<std::tuple<int, int, int, int>> places;
    for (const BlobCandidate& c : found) {
      EXPECT_GT(c.response, kMin);
      EXPECT_EQ(c.response, box_hessian_at(integral, c.x, c.y, c.lobe).determinant());
      EXPECT_TRUE(is_maximum(integral, c.x, c.y, c.lobe, c.lobe_step, c.lobe_step / 2));
      EXPECT_TRUE(places.emplace(c.lobe_step, c.lobe, c.x, c.y).second);
    }
    for (int octave = 0; octave < octaves; ++octave) {
      const int lobe_step = 2 << octave, step = kStep << octave;
      for (int lobe = 1 + (octave == 0 ? 1 : 2) * lobe_step; lobe < 1 + 4 * lobe_step;
           lobe += lobe_step) {
        const int border = (filter_margin(lobe + lobe_step) / step + 3) * step;
        for (int y = border; y < kHeight - border; y += step)
          for (int x = border; x < kWidth - border; x += step)
            if (box_hessian_at(integral, x, y, lobe).determinant() > kMin &&
                is_maximum(integral, x, y, lobe, lobe_step, step)) {
              EXPECT_TRUE(places.contains({lobe_step, lobe, x, y}))
                  << "octave " << octave << ", lobe " << lobe << " at " << x << ' ' << y;
            }
      }
    }
  }
}

}  // namespace
}  // namespace eifmap
