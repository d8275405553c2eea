// Another start for the mean is no information: the filter ends where it was.
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "support/filter_world.h"

namespace eifmap::test {
namespace {

std::vector<Rigid3> poses_of(const InformationFilter& filter) {
  std::vector<Rigid3> poses;
  for (int p = 0; p < filter.num_poses(); ++p) poses.push_back(filter.pose(p));
  return poses;
}

std::vector<std::pair<int, Eigen::Vector3d>> positions_of(const InformationFilter& filter) {
  std::vector<std::pair<int, Eigen::Vector3d>> positions;
  for (int l = 0; l < filter.num_landmarks(); ++l) positions.emplace_back(l, filter.position(l));
  return positions;
}

TEST(Move, IsAStartAndNoInformation) {
  FilterOptions options;
  options.max_iterations = 30;
  FilterWorld world = make_filter_world({}, options);
  for (int k = 0; k < 5; ++k) world.filter.update();
  InformationFilter moved = world.filter;
  Random random(9);
  const auto noise3 = [&random](double size) {
    return Eigen::Vector3d(size * random.normal_vector<3>());
  };
  std::vector<Rigid3> poses = poses_of(moved);
  for (std::size_t p = 1; p < poses.size(); ++p)
    poses[p] = retract(poses[p], noise3(0.01), noise3(0.05));
  auto positions = positions_of(moved);
  for (auto& [l, position] : positions) position += noise3(0.05);
  moved.move(poses, positions);
  EXPECT_EQ(moved.pose(3).translation, poses[3].translation);
  EXPECT_EQ(moved.position(4), positions[4].second);
  EXPECT_EQ(moved.update().reason, Reason::kNone);
  moved.update();
  EXPECT_EQ(moved.num_measurements(), world.filter.num_measurements()) << "nothing was dropped";
  for (int p = 0; p < moved.num_poses(); ++p) {
    EXPECT_LT((moved.pose(p).translation - world.filter.pose(p).translation).norm(), 1e-3) << p;
    if (p == 0) continue;
    PoseBlock a = PoseBlock::Zero(), b = a;
    EXPECT_TRUE(moved.pose_covariance(p, a) && world.filter.pose_covariance(p, b));
    EXPECT_LT((a - b).norm(), 0.02 * b.norm()) << p;
  }
}

TEST(Move, RefusesWhatMakesNoSense) {
  FilterWorld world = make_filter_world({});
  std::vector<Rigid3> poses = poses_of(world.filter);
  EXPECT_THROW(world.filter.move(poses, {}), std::invalid_argument) << "there is no gauge yet";
  world.filter.update();
  poses = poses_of(world.filter);
  EXPECT_NO_THROW(world.filter.move(poses, {}));
  auto other = poses;
  other.pop_back();
  EXPECT_THROW(world.filter.move(other, {}), std::invalid_argument);
  other = poses;
  other[0].translation.x() += 1e-9;
  EXPECT_THROW(world.filter.move(other, {}), std::invalid_argument) << "the gauge";
  other = poses;
  other[2].translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world.filter.move(other, {}), std::invalid_argument);
  EXPECT_THROW(world.filter.move(poses, {{world.filter.num_landmarks(), {0, 0, 1}}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace eifmap::test
