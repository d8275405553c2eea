#include "simulation/feature_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "frame_check.h"

namespace eifmap {
namespace {

FeatureWorldOptions world_of(const std::string& motion) {
  FeatureWorldOptions options;
  options.motion = motion;
  return options;
}

// Projections of their points, but for a noise of the size that was asked for.
TEST(FeatureWorld, KeypointsAreWhereTheirPointsAreButForTheNoise) {
  for (const char* motion : {"sideways", "forward", "loop"}) {
    const FeatureWorld world(world_of(motion));
    double squares = 0, sum = 0;
    int count = 0;
    for (int i = 0; i < world.num_frames(); i += 9) {
      const SimulatedFeatures seen = world.frame(i);
      const Rigid3 camera_from_world = world.world_from_camera(i).inverse();
      for (std::size_t k = 0; k < seen.point.size(); ++k) {
        const Eigen::Vector3d x = camera_from_world * world.points()[seen.point[k]];
        const Eigen::Vector2d p = world.camera().pixel_from_normalized(x.hnormalized());
        for (const double d :
             {seen.frame.keypoints[k].u - p.x(), seen.frame.keypoints[k].v - p.y()})
          squares += d * d, sum += d, ++count;
      }
    }
    EXPECT_GT(count, 4000) << motion;
    EXPECT_NEAR(std::sqrt(squares / count), 0.5, 0.02) << motion;
    EXPECT_NEAR(sum / count, 0, 0.03) << motion;
  }
}

TEST(FeatureWorld, GivesFramesThatTheMapperTakesAndTheSameTwice) {
  for (const char* motion : {"sideways", "forward", "loop"}) {
    const FeatureWorld world(world_of(motion)), again(world_of(motion));
    for (int i = 0; i < world.num_frames(); i += 25) {
      const FeatureFrame frame = world.frame(i).frame, same = again.frame(i).frame;
      const FrameCheck check = check_frame(frame, world.camera());
      EXPECT_TRUE(check.ok()) << motion << i << ": " << check.detail;
      EXPECT_GT(frame.keypoints.size(), 150u) << motion << i;
      EXPECT_LE(frame.keypoints.size(), 1000u);
      EXPECT_EQ(frame.descriptors, same.descriptors);
      EXPECT_EQ(frame.keypoints[9].u, same.keypoints[9].u);
      for (std::size_t k = 1; k < frame.keypoints.size(); ++k)
        EXPECT_GE(frame.keypoints[k - 1].response, frame.keypoints[k].response);
    }
  }
}

// How far points are from where they are, by point.
std::map<int, Eigen::Vector2d> displacements(const FeatureWorld& world, int i) {
  const SimulatedFeatures seen = world.frame(i);
  const Rigid3 camera_from_world = world.world_from_camera(i).inverse();
  std::map<int, Eigen::Vector2d> displacements;
  for (std::size_t k = 0; k < seen.point.size(); ++k) {
    const Eigen::Vector3d x = camera_from_world * world.points()[seen.point[k]];
    const Keypoint& keypoint = seen.frame.keypoints[k];
    displacements[seen.point[k]] = Eigen::Vector2d(keypoint.u, keypoint.v) -
                                   world.camera().pixel_from_normalized(x.hnormalized());
  }
  return displacements;
}

// Of the size that was asked for; much the same in the next image, and another from elsewhere.
TEST(FeatureWorld, PointsDriftWithTheViewingDirection) {
  FeatureWorldOptions options;
  options.noise_px = 0;
  options.drift_px = 0.4;
  const FeatureWorld world(options);
  const auto correlation = [&world](int lag) {
    double products = 0, squares = 0, count = 0;
    for (int i = 0; i + lag < world.num_frames(); i += 7) {
      const auto then = displacements(world, i + lag);
      for (const auto& [point, d] : displacements(world, i)) {
        if (!then.contains(point)) continue;
        products += d.dot(then.at(point)), squares += d.squaredNorm(), ++count;
      }
    }
    EXPECT_NEAR(std::sqrt(squares / (2 * count)), 0.4, 0.04);
    return products / squares;
  };
  EXPECT_GT(correlation(1), 0.9);   // .12 m at 4-10 m: 1 degree
  EXPECT_LT(correlation(15), 0.3);  // 15 degrees
}

std::map<int, std::vector<std::int8_t>> looks(const SimulatedFeatures& seen) {
  std::map<int, std::vector<std::int8_t>> looks;
  for (std::size_t k = 0; k < seen.point.size(); ++k) {
    const auto begin = seen.frame.descriptors.begin() + static_cast<long>(k) * kDescriptorSize;
    looks[seen.point[k]].assign(begin, begin + kDescriptorSize);
  }
  return looks;
}

// A point looks the same from everywhere; the share that was asked for looks like another that is
// in the same image and of the same sign.
TEST(FeatureWorld, AsManyAreMistakenAsAskedFor) {
  FeatureWorldOptions options;
  options.wrong_share = 0;
  const FeatureWorld right(options);
  options.wrong_share = 0.2;
  const FeatureWorld wrong(options);
  int mistaken = 0, all = 0;
  for (int i = 0; i < 100; i += 5) {
    const auto truth = looks(right.frame(i)), next = looks(right.frame(i + 1));
    for (const auto& [point, descriptor] : next)
      if (truth.contains(point)) {
        EXPECT_EQ(truth.at(point), descriptor);
      }
    for (const auto& [point, descriptor] : looks(wrong.frame(i))) {
      ++all;
      if (truth.at(point) == descriptor) continue;
      ++mistaken;
      const auto other = std::find_if(truth.begin(), truth.end(),
                                      [&d = descriptor](const auto& t) { return t.second == d; });
      ASSERT_NE(other, truth.end());
      EXPECT_EQ((other->first - point) % 2, 0);
    }
  }
  EXPECT_NEAR(static_cast<double>(mistaken) / all, 0.2, 0.02);
}

TEST(FeatureWorld, TheLoopComesBack) {
  FeatureWorldOptions options = world_of("loop");
  options.num_frames = 288;
  const FeatureWorld world(options);
  const auto first = looks(world.frame(0)), again = looks(world.frame(262));
  int both = 0;
  for (const auto& [point, descriptor] : first) both += again.contains(point);
  EXPECT_GT(both, 0.5 * static_cast<double>(first.size()));
  EXPECT_GT(
      (world.world_from_camera(0).translation - world.world_from_camera(131).translation).norm(),
      9);
}

TEST(FeatureWorld, SaysWhichOptionIsWrong) {
  FeatureWorldOptions options;
  options.motion = "hop";
  EXPECT_NE(options.problem().find("'hop'"), std::string::npos);
  EXPECT_THROW(FeatureWorld{options}, std::invalid_argument);
  EXPECT_THROW(FeatureWorld().frame(100), std::out_of_range);
}

}  // namespace
}  // namespace eifmap
