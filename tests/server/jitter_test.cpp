#include "server/jitter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace eifmap {
namespace {

FeatureFrame frame_of(int n) {
  FeatureFrame frame;
  frame.width = 1000;
  frame.height = 1000;
  frame.keypoints.resize(static_cast<std::size_t>(n));
  for (Keypoint& k : frame.keypoints) k.u = k.v = 500;
  return frame;
}

TEST(Jitter, HasTheSigmaAskedFor) {
  FeatureFrame frame = frame_of(20000);
  Jitter(2.0, 1).apply(frame);
  double sum = 0, squares = 0, product = 0;
  for (const Keypoint& k : frame.keypoints) {
    const double u = k.u - 500.0, v = k.v - 500.0;
    sum += u + v;
    squares += u * u + v * v;
    product += u * v;
  }
  EXPECT_NEAR(sum / 40000, 0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / 40000), 2.0, 0.05);
  EXPECT_NEAR(product / 20000, 0, 0.15);
}

TEST(Jitter, FollowsTheSeed) {
  FeatureFrame a = frame_of(10), b = frame_of(10), c = frame_of(10);
  Jitter(1.0, 5).apply(a);
  Jitter(1.0, 5).apply(b);
  Jitter(1.0, 6).apply(c);
  EXPECT_EQ(a.keypoints[3].u, b.keypoints[3].u);
  EXPECT_NE(a.keypoints[3].u, c.keypoints[3].u);
}

TEST(Jitter, NothingLeavesTheImage) {
  FeatureFrame frame = frame_of(2000);
  for (Keypoint& k : frame.keypoints) k.u = k.v = 0;
  Jitter(50.0, 1).apply(frame);
  for (const Keypoint& k : frame.keypoints) {
    EXPECT_GE(k.u, -0.5f);
    EXPECT_GE(k.v, -0.5f);
  }
}

TEST(Jitter, ZeroIsExact) {
  FeatureFrame frame = frame_of(5);
  Jitter(0, 1).apply(frame);
  EXPECT_EQ(frame.keypoints[4].u, 500);
  EXPECT_THROW(Jitter(-1, 1), std::invalid_argument);
  EXPECT_THROW(Jitter(NAN, 1), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
