#include "map/observed_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace eifmap {
namespace {

Camera camera_of(CameraModel model, double focal) {
  return {640, 480, model, focal, focal, 319.5, 239.5, {}};
}

// Keypoints all over the image, each with a descriptor of its own; the signs alternate.
FeatureFrame frame_of(const Camera& camera) {
  FeatureFrame frame;
  frame.width = camera.width;
  frame.height = camera.height;
  for (int k = 0; k < 300; ++k) {
    Keypoint keypoint;
    keypoint.u = static_cast<float>(k * 37 % 640);
    keypoint.v = static_cast<float>(k * 53 % 480);
    keypoint.sigma_px = 0.5f;
    keypoint.laplacian_sign = k % 2 ? 1 : -1;
    frame.keypoints.push_back(keypoint);
    for (int i = 0; i < kDescriptorSize; ++i)
      frame.descriptors.push_back(static_cast<std::int8_t>((k * 7 + i * 11) % 251 - 125));
  }
  return frame;
}

TEST(ObservedFrame, OfAPinholeKeepsEverythingAsItIs) {
  const Camera camera = camera_of(CameraModel::kPinhole, 500);
  const FeatureFrame frame = frame_of(camera);
  const ObservedFrame observed = observe(frame, camera, MapSign::kMinus, 2);
  ASSERT_EQ(observed.size(), 300);
  for (double sigma : observed.sigma) EXPECT_EQ(sigma, 2 * 0.5 / 500);
  EXPECT_EQ(observed.frame.descriptors, frame.descriptors);
}

// 640 px of an ideal fisheye with this focal length are 229 degrees.
TEST(ObservedFrame, LeavesOutWhatIsTooFarFromTheAxis) {
  const Camera camera = camera_of(CameraModel::kFisheye, 160);
  ASSERT_EQ(camera.problem(), "");
  const FeatureFrame frame = frame_of(camera);
  const ObservedFrame observed = observe(frame, camera, MapSign::kMinus, 2);
  ASSERT_GT(observed.size(), 120);
  ASSERT_LT(observed.size(), 280);
  ASSERT_EQ(observed.frame.keypoints.size(), observed.x.size());
  ASSERT_EQ(observed.sigma.size(), observed.x.size());

  int kept = 0;
  for (int k = 0; k < 300; ++k) {
    const Keypoint& keypoint = frame.keypoints[k];
    const double radius = std::hypot(keypoint.u - camera.cx, keypoint.v - camera.cy);
    if (radius > 160 * kMaxViewAngle) continue;
    ASSERT_LT(kept, observed.size());
    EXPECT_EQ(observed.frame.keypoints[kept].u, keypoint.u);
    EXPECT_EQ(observed.frame.keypoints[kept].v, keypoint.v);
    EXPECT_TRUE(std::equal(observed.descriptor(kept), observed.descriptor(kept) + kDescriptorSize,
                           frame.descriptors.begin() + k * kDescriptorSize));
    EXPECT_TRUE(observed.x[kept].allFinite());
    ++kept;
  }
  EXPECT_EQ(kept, observed.size());
  EXPECT_EQ(observed.minus.index.size() + observed.plus.index.size(), observed.x.size());
  for (int k : observed.minus.index) EXPECT_EQ(observed.frame.keypoints[k].laplacian_sign, -1);
}

// Outwards the image is squeezed: one pixel there is more.
TEST(ObservedFrame, SigmaGrowsTowardsTheEdgeOfAFisheye) {
  const Camera camera = camera_of(CameraModel::kFisheye, 300);
  const ObservedFrame observed = observe(frame_of(camera), camera, MapSign::kMinus, 2);
  for (int k = 0; k < observed.size(); ++k) {
    const double r = observed.x[k].norm(), theta = std::atan(r);
    const double area = r < 1e-6 ? 1 : (1 + r * r) * r / theta;
    EXPECT_NEAR(observed.sigma[k] * 300, std::sqrt(area), 1e-9);
  }
}

}  // namespace
}  // namespace eifmap
