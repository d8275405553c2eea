// Standing still does not make the map grow: real images of a camera that stands.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "features/front_end.h"
#include "mapper.h"
#include "sequence/recorded_sequence.h"

namespace eifmap::test {
namespace {

// Depths of a made-up scene behind an image: rough, so that no plane explains it.
double depth_at(std::size_t keypoint) {
  return 4 + 3 * static_cast<double>(keypoint * 2654435761u % 1000) / 1000;
}

// What a camera would have seen of the features of `frame`, had it been at `frame_from_camera`.
FeatureFrame seen_from(const FeatureFrame& frame, const Camera& camera,
                       const Rigid3& frame_from_camera) {
  FeatureFrame moved = frame;
  moved.keypoints.clear();
  moved.descriptors.clear();
  for (std::size_t k = 0; k < frame.keypoints.size(); ++k) {
    Keypoint keypoint = frame.keypoints[k];
    const Eigen::Vector2d x = camera.normalized_from_pixel({keypoint.u, keypoint.v});
    const Eigen::Vector3d point =
        frame_from_camera.inverse() * Eigen::Vector3d(depth_at(k) * x.homogeneous());
    const Eigen::Vector2d pixel = camera.pixel_from_normalized(point.hnormalized());
    if (pixel.minCoeff() < 0 || pixel.x() > camera.width - 1 || pixel.y() > camera.height - 1)
      continue;
    keypoint.u = static_cast<float>(pixel.x());
    keypoint.v = static_cast<float>(pixel.y());
    moved.keypoints.push_back(keypoint);
    const auto descriptor =
        frame.descriptors.begin() + static_cast<std::ptrdiff_t>(k * kDescriptorSize);
    moved.descriptors.insert(moved.descriptors.end(), descriptor, descriptor + kDescriptorSize);
  }
  return moved;
}

struct Size {
  std::int64_t keyframes = 0, landmarks = 0;
};

TEST(Standstill, RecordedDoesNotMakeTheMapGrow) {
  const char* shared = std::getenv("EIFMAP_SHARED");
  const std::filesystem::path folder =
      std::filesystem::path(shared ? shared : EIFMAP_SHARED_DEFAULT) / "data" / "standstill";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no " << folder;
  const RecordedSequence::Opened opened = RecordedSequence::open(folder);
  ASSERT_TRUE(opened.sequence) << opened.problem;
  const Camera& camera = opened.sequence->camera();
  FeatureExtractor extractor;
  std::vector<FeatureFrame> images;
  for (int i = 0; i < opened.sequence->size(); ++i)
    images.push_back(
        extract_frame(extractor, opened.sequence->load_gray(i).image, camera, {1, 1, i, "cam0"}));

  Mapper mapper(camera, {});
  std::int64_t seq = 0;
  const auto process = [&](FeatureFrame frame) {
    frame.seq = ++seq;
    frame.time_us = 50'000 * seq;
    return mapper.process(frame);
  };
  const auto size = [&] {
    return Size{mapper.statistics().keyframes, mapper.statistics().landmarks};
  };
  // Up to where the images were taken, then 300 of those.
  constexpr int kSteps = 30;
  for (int i = 0; i < kSteps; ++i)
    process(seen_from(images[0], camera,
                      {Eigen::Quaterniond::Identity(), {0.05 * (i - kSteps), 0, 0}}));
  ASSERT_GT(size().keyframes, 3);
  for (const FeatureFrame& image : images) process(image);  // the last step ends in a keyframe
  const Size before = size();
  for (int round = 0; round < 9; ++round)
    for (const FeatureFrame& image : images)
      EXPECT_EQ(process(image).state, TrackingState::kTracking);
  EXPECT_LE(size().keyframes, before.keyframes);
  EXPECT_NEAR(static_cast<double>(size().landmarks), static_cast<double>(before.landmarks),
              0.02 * static_cast<double>(before.landmarks));
  EXPECT_EQ(mapper.statistics().losses, 0);
}

}  // namespace
}  // namespace eifmap::test
