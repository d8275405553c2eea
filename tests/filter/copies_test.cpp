// A copy of a filter goes its own way, though most of what the two hold is shared.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "support/long_way.h"

namespace eifmap::test {
namespace {

// All that can be asked of a filter, to the bit.
std::string all_of(const InformationFilter& filter) {
  std::ostringstream out;
  const auto write = [&out](const auto& m) {
    out.write(reinterpret_cast<const char*>(m.data()),
              static_cast<std::streamsize>(sizeof(double) * static_cast<std::size_t>(m.size())));
  };
  for (int p = 0; p < filter.num_poses(); ++p) {
    write(filter.pose(p).translation), write(filter.pose(p).rotation.coeffs());
    PoseBlock covariance;
    if (filter.pose_covariance(p, covariance)) write(covariance);
  }
  for (int l = 0; l < filter.num_landmarks(); ++l) {
    const FilterLandmark& landmark = filter.landmark(l);
    write(landmark.position), write(landmark.covariance);
    for (const PointMeasurement& m : landmark.measurements)
      out << m.pose << ' ' << m.sigma << ' ', write(m.d_pose()), write(m.residual);
  }
  for (const FilterEdge& edge : filter.edges()) write(edge.measurement.sqrt_information);
  return out.str();
}

LongWay way() {
  return make_long_way(round_course(60, 45), {.points_per_pose = 8});
}

// Everything that changes a filter, done to a copy of it.
TEST(Copies, NothingThatHappensToACopyChangesTheOther) {
  const LongWay world = way();
  LongWayFeed feed(world, FilterOptions{});
  while (feed.num_poses() < 50) feed.add_next(), feed.filter().update();
  const Rigid3 relative = feed.filter().pose(2).inverse() * feed.filter().pose(5);
  RelativePose edge;
  edge.i_from_j = relative.rotation;
  edge.direction = relative.translation.normalized();
  edge.covariance = 1e-4 * Eigen::Matrix<double, 5, 5>::Identity();
  EXPECT_TRUE(feed.filter().add_edge(2, 5, edge));
  const InformationFilter& filter = feed.filter();
  const std::string before = all_of(filter);
  const auto change = [&](auto&& what) {
    InformationFilter copy = filter;
    what(copy);
    copy.update();
    EXPECT_EQ(all_of(filter), before);
    EXPECT_NE(all_of(copy), before);
  };
  change([](InformationFilter& f) { f.remove_landmark(10); });
  change([](InformationFilter& f) { f.remove_pose(20); });
  change([](InformationFilter& f) { f.scale_sigmas(1.5); });
  change([](InformationFilter& f) { f.make_metric(2); });
  change([](InformationFilter& f) { f.iterate_whole(); });
  change([](InformationFilter& f) {
    const int l = f.add_landmark(f.position(f.num_landmarks() - 1), Eigen::Matrix3d::Identity());
    for (int p : {47, 48, 49}) f.add_measurement(l, p, Eigen::Vector2d(0.01, 0), 0.01);
  });
}

// As the mapper does: each keyframe goes into a copy, and the filter before it is let go.
TEST(Copies, AFilterOfCopiesOfCopiesIsToTheBitOneThatWasNeverCopied) {
  const LongWay world = way();
  LongWayFeed copied(world, FilterOptions{}), alone(world, FilterOptions{});
  while (!alone.done()) {
    copied.add_next(), alone.add_next();
    InformationFilter next = copied.filter();
    next.update(), alone.filter().update();
    copied.filter() = std::move(next);
  }
  EXPECT_EQ(all_of(copied.filter()), all_of(alone.filter()));
}

// And the one before stays what it was while the copy goes on.
TEST(Copies, TheOneBeforeStaysWhatItWas) {
  const LongWay world = way();
  LongWayFeed feed(world, FilterOptions{});
  while (!feed.done()) {
    const InformationFilter before = feed.filter();
    const std::string all = feed.num_poses() % 10 == 9 ? all_of(before) : std::string();
    feed.add_next();
    feed.filter().update();
    if (all.empty()) continue;
    EXPECT_EQ(all_of(before), all) << feed.num_poses();
  }
}

}  // namespace
}  // namespace eifmap::test
