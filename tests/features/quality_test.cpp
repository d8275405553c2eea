// What is promised of our features beside OpenCV's: src/features/quality.md.
#include "features/quality.h"

#include <gtest/gtest.h>

namespace eifmap::testing {
namespace {

const PairFigures& of(const Row& row, Method method) {
  return row.of[static_cast<std::size_t>(method)];
}

void expect_as_good(const PairFigures& ours, const Row& row) {
  const PairFigures &sift = of(row, Method::kOpenCvSift), &akaze = of(row, Method::kOpenCvAkaze);
  EXPECT_LE(ours.rms(), 1.5 * sift.rms());
  EXPECT_GE(ours.repeatability(), sift.repeatability() - 0.12);
  EXPECT_GE(ours.repeatability(), akaze.repeatability() - 0.18);
  EXPECT_GE(ours.precision(), sift.precision() - 0.04);
  EXPECT_GE(ours.precision(), akaze.precision() - 0.04);
  EXPECT_GE(ours.right, 0.8 * sift.right);
  EXPECT_GE(ours.right, 0.75 * akaze.right);
}

TEST(Quality, IsThatOfSiftAndAkaze) {
  for (const Row& row : measure_quality(2)) {
    SCOPED_TRACE(row.change.name);
    {
      SCOPED_TRACE("oriented");
      expect_as_good(of(row, Method::kSurfOriented), row);
    }
    if (std::abs(row.change.turn_deg) > 10) continue;
    SCOPED_TRACE("upright");
    expect_as_good(of(row, Method::kSurfUpright), row);
  }
}

}  // namespace
}  // namespace eifmap::testing
