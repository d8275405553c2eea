// The filter along a way of many keyframes past points that come and go.
#include "support/long_way.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace eifmap::test {
namespace {

struct Walk {
  int failed = 0;         // updates
  double farthest = 0;    // m, of a pose from where it truly is, at the end
  double worst_jump = 0;  // m: what an update moved the pose half way along, once it was old
};

// Nothing asks for parallax here: points straight ahead, that all poses see almost along one ray,
// go into the map as well.
Walk walk(const LongWay& world, const FilterOptions& options) {
  LongWayFeed feed(world, options);
  Walk result;
  const int half = static_cast<int>(world.poses.size()) / 2;
  constexpr int kOld = 30;  // keyframes ago
  while (!feed.done()) {
    feed.add_next();
    const bool old = feed.num_poses() > half + kOld;
    const Eigen::Vector3d before = old ? feed.filter().pose(half).translation : Eigen::Vector3d();
    const FilterUpdate update = feed.filter().update();
    // Two poses have no point in common that has been seen three times.
    if (feed.num_poses() > 3 && update.reason != Reason::kNone) ++result.failed;
    if (old)
      result.worst_jump =
          std::max(result.worst_jump, (feed.filter().pose(half).translation - before).norm());
  }
  for (int p = 0; p < feed.num_poses(); ++p)
    result.farthest = std::max(
        result.farthest, (feed.filter().pose(p).translation - world.poses[p].translation).norm());
  return result;
}

// The walk is 160 m long. The filter that linearizes everything again in every iteration, which
// is exact, ends within 0.6 m.
TEST(LongWay, ArrivesThoughPointsLieAheadAlongOneRay) {
  const LongWay world = make_long_way(round_course(200, 1000), {});
  const Walk walked = walk(world, FilterOptions{});
  EXPECT_EQ(walked.failed, 0);
  EXPECT_LT(walked.farthest, 1.0);
  EXPECT_LT(walked.worst_jump, 0.1);
}

// Of many poses at once the inverse's blocks where the factor has any do; one by one a column each.
TEST(LongWay, CovariancesOfAllAtOnceAreThoseOfEach) {
  const LongWay world = make_long_way(round_course(180, 160), {});
  LongWayFeed feed(world, {});
  while (!feed.done()) {
    feed.add_next();
    feed.filter().update();
  }
  const InformationFilter& filter = feed.filter();
  std::vector<int> poses, landmarks;
  for (int p = 0; p < filter.num_poses(); ++p) poses.push_back(p);
  for (int l = 0; l < filter.num_landmarks(); ++l)
    if (!filter.landmark(l).measurements.empty()) landmarks.push_back(l);
  std::vector<PoseBlock> of_poses;
  std::vector<Eigen::Matrix3d> of_landmarks;
  ASSERT_TRUE(filter.covariances(poses, landmarks, of_poses, of_landmarks));
  for (int p = 1; p < filter.num_poses(); p += 7) {
    PoseBlock alone;
    ASSERT_TRUE(filter.pose_covariance(p, alone));
    EXPECT_LT((of_poses[p] - alone).norm(), 1e-7 * alone.norm()) << "pose " << p;
  }
  for (std::size_t k = 0; k < landmarks.size(); k += 97) {
    Eigen::Matrix3d alone;
    ASSERT_TRUE(filter.landmark_covariance(landmarks[k], alone));
    EXPECT_LT((of_landmarks[k] - alone).norm(), 1e-7 * alone.norm()) << "landmark " << k;
  }
}

}  // namespace
}  // namespace eifmap::test
