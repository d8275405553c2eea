#include "published_path.h"

#include <gtest/gtest.h>

namespace eifmap {
namespace {

FrameResult frame(std::int64_t map_id, ScaleStatus scale, double x,
                  TrackingState state = TrackingState::kTracking) {
  FrameResult result;
  result.map_id = map_id;
  result.state = state;
  result.scale.status = scale;
  if (scale == ScaleStatus::kFixed) result.scale.metres_per_unit = 3;
  result.map_from_camera.translation.x() = x;
  return result;
}

std::vector<double> xs(const PublishedPath& path) {
  std::vector<double> xs;
  for (const TimedPose& pose : path.poses()) xs.push_back(pose.world_from_camera.translation.x());
  return xs;
}

using Xs = std::vector<double>;

TEST(PublishedPath, IsInMetresWhereAMapBecameMetric) {
  PublishedPath path;
  path.add(frame(1, ScaleStatus::kFree, 5));
  EXPECT_FALSE(path.has_become_metric());
  path.add(frame(1, ScaleStatus::kFixed, 0, TrackingState::kLost));
  EXPECT_TRUE(path.has_become_metric());
  path.add(frame(1, ScaleStatus::kFixed, 16));
  path.add(frame(2, ScaleStatus::kFree, 7));
  EXPECT_EQ(xs(path), (Xs{15, 16, 7}));
  path.note_scale(2, {});
  EXPECT_EQ(xs(path), (Xs{15, 16, 7}));
  path.note_scale(path.last_map_id(), {ScaleStatus::kFixed, 10});
  EXPECT_EQ(xs(path), (Xs{15, 16, 70}));
}

TEST(PublishedPath, IsAsPublishedElse) {
  PublishedPath path;
  FrameResult rejected = frame(1, ScaleStatus::kFree, 5);
  rejected.rejected = true;
  path.add(rejected);
  path.add(frame(1, ScaleStatus::kFixed, 16));
  EXPECT_EQ(xs(path), Xs{16});
  EXPECT_FALSE(path.has_become_metric());
}

}  // namespace
}  // namespace eifmap
