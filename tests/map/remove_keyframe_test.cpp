// A keyframe taken out of a map: what is left is a map of its own right.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "map/audit.h"
#include "map/keyframe_insertion.h"
#include "map/map_news.h"
#include "map/trajectory_log.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

bool same(const Rigid3& a, const Rigid3& b, double within) {
  return (a.translation - b.translation).norm() <= within &&
         a.rotation.angularDistance(b.rotation) <= within;
}

// Six keyframes with landmarks, and an edge of each with the one before.
Map scene(const SyntheticStream& world) {
  const MapperOptions options;
  Map map = scene_with_landmarks(world, 6);
  map.update();
  for (int k = 1; k < 6; ++k) add_edge_from_map(map, k - 1, k, options);
  EXPECT_EQ(map.update().reason, Reason::kNone);
  EXPECT_GT(map.filter().num_edges(), 3);
  return map;
}

void expect_nothing_of(const Map& map, int keyframe) {
  for (int t = 0; t < map.num_tracks(); ++t)
    for (const Sight& s : map.track(t).sights) EXPECT_NE(s.keyframe, keyframe);
  for (const FilterEdge& edge : map.filter().edges())
    EXPECT_TRUE(edge.i != keyframe && edge.j != keyframe);
  for (int k = 0; k < map.num_keyframes(); ++k)
    if (k != keyframe && !map.is_removed(k)) {
      const std::vector<int> seen = map.covisible(k, 100);
      EXPECT_EQ(std::count(seen.begin(), seen.end(), keyframe), 0);
    }
  for (const std::string& problem : audit(map)) ADD_FAILURE() << problem;
}

TEST(RemoveKeyframe, LeavesNothingOfItAndAMapThatSettles) {
  const SyntheticStream world;
  Map map = scene(world);
  const int before = map.filter().num_edges(), landmarks = map.num_landmarks();
  map.remove_keyframe(3);
  expect_nothing_of(map, 3);
  EXPECT_TRUE(map.is_removed(3));
  EXPECT_EQ(map.num_keyframes(), 6);
  EXPECT_EQ(map.num_keyframes_in_use(), 5);
  EXPECT_EQ(map.filter().num_edges(), before - 2);
  EXPECT_EQ(map.keyframe(3).observed().size(), 0);
  EXPECT_EQ(map.keyframe(3).time_us, world.view(3, scene_pose(3)).time_us);
  EXPECT_EQ(map.num_landmarks(), landmarks) << "others see them";
  EXPECT_EQ(map.update().reason, Reason::kNone);
  expect_nothing_of(map, 3);
  for (int k = 2; k < 6; ++k) EXPECT_TRUE(same(map.pose(k), scene_pose(k), 0.05)) << k;
}

// What is left is as if it had never been: mean and covariances.
TEST(RemoveKeyframe, IsAsIfItHadNeverBeen) {
  const SyntheticStream world;
  FilterOptions exact;
  exact.relinearize = Relinearize::kAlways;
  exact.max_iterations = 30;
  MapperOptions options;
  options.filter = exact;
  Map with = make_scene(world, 6, options), without = make_scene(world, 6, options);
  const Map known = scene_with_landmarks(world, 6);
  for (int t = 0; t < known.num_tracks(); ++t)
    for (Map* map : {&with, &without}) {
      int track = -1;
      for (const Sight& s : known.track(t).sights) {
        if (map == &without && s.keyframe == 3) continue;
        track < 0 ? (track = map->add_track(s)) : static_cast<int>(map->add_sight(track, s));
      }
      map->promote(track, known.position(t), Eigen::Matrix3d::Identity());
    }
  with.update();
  with.remove_keyframe(3);
  with.update();
  without.remove_keyframe(3);  // that nothing measures
  without.update();
  const auto covariance = [](const Map& map, int keyframe) {
    PoseBlock block = PoseBlock::Zero();
    EXPECT_TRUE(map.filter().pose_covariance(keyframe, block));
    return block;
  };
  for (const int k : {1, 2, 4, 5}) {
    EXPECT_TRUE(same(with.pose(k), without.pose(k), 1e-5)) << k;
    const PoseBlock expected = covariance(without, k);
    EXPECT_LT((covariance(with, k) - expected).norm(), 0.02 * expected.norm()) << k;
  }
}

TEST(RemoveKeyframe, ItsFramesFollowTheKeyframeThatSharedMost) {
  const SyntheticStream world;
  Map map = scene(world);
  TrajectoryLog log;
  const Rigid3 from_it({1, 0, 0, 0}, {0.1, 0.2, 0.3});
  log.add(1000, 4, from_it);
  const Rigid3 before = map.pose(4);
  map.remove_keyframe(4);
  const int carrier = map.keyframe(4).carrier;
  const Rigid3 relative = map.pose(carrier).inverse() * before;
  map.update();
  EXPECT_TRUE(same(map.pose(4), map.pose(carrier) * relative, 1e-9));
  EXPECT_TRUE(same(log.in(map).front().world_from_camera, map.pose(4) * from_it, 1e-9));
  // And the next one, when that goes too.
  map.remove_keyframe(carrier);
  const int next = map.keyframe(carrier).carrier;
  EXPECT_EQ(map.keyframe(4).carrier, next);
  map.update();
  EXPECT_TRUE(same(map.pose(4), map.pose(carrier) * relative, 1e-9));
  EXPECT_TRUE(same(map.pose(4), scene_pose(4), 0.1));
}

TEST(RemoveKeyframe, HasNoCovarianceAndIsStillAPlace) {
  const SyntheticStream world;
  Map map = scene(world);
  MapNews news;
  EXPECT_EQ(news.since_last(map).keyframes.size(), 6u);
  map.remove_keyframe(2);
  map.update();
  PoseBlock covariance;
  EXPECT_FALSE(map.filter().pose_covariance(2, covariance));
  EXPECT_TRUE(map.filter().pose_covariance(4, covariance));
  EXPECT_EQ(keyframe_views(map).size(), 5u);
  const MapUpdate whole = MapNews().since_last(map);
  ASSERT_EQ(whole.keyframes.size(), 6u);
  EXPECT_FALSE(whole.keyframes[2].covariance.allFinite());
  EXPECT_TRUE(whole.keyframes[3].covariance.allFinite());
  for (const LandmarkView& landmark : whole.landmarks) EXPECT_NE(landmark.anchor, 2);
}

TEST(RemoveKeyframe, TakesWhatOnlyItAndOneOtherSaw) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 5);
  int of_two = -1;
  for (int t = 0; t < map.num_tracks() && of_two < 0; ++t)
    if (map.track(t).sights.size() == 5) of_two = t;
  ASSERT_GE(of_two, 0);
  for (const int k : {1, 2, 4}) map.remove_sight(of_two, k);
  map.update();
  ASSERT_TRUE(map.track(of_two).is_landmark());
  const int landmarks = map.num_landmarks();
  map.remove_keyframe(3);
  EXPECT_FALSE(map.track(of_two).is_landmark());
  EXPECT_LT(map.num_landmarks(), landmarks);
  EXPECT_EQ(map.update().reason, Reason::kNone);
  expect_nothing_of(map, 3);
}

TEST(RemoveKeyframe, FreesTheMeasurementsOfItsEdges) {
  const SyntheticStream world;
  Map map = scene(world);
  const auto spent = [&map](int k) {
    return std::count(map.keyframe(k).spent.begin(), map.keyframe(k).spent.end(), 1);
  };
  const auto before = spent(5);
  ASSERT_GT(before, 0);
  map.remove_keyframe(4);
  EXPECT_LT(spent(5), before);
  EXPECT_TRUE(audit(map).empty());
}

TEST(RemoveKeyframe, RefusesTheGaugeAndWhatIsGone) {
  const SyntheticStream world;
  Map map = scene(world);
  for (const int k : {-1, 0, 1, 6}) EXPECT_THROW(map.remove_keyframe(k), std::invalid_argument);
  map.remove_keyframe(2);
  EXPECT_THROW(map.remove_keyframe(2), std::invalid_argument);
  EXPECT_THROW(map.filter().add_measurement(0, 2, {0, 0}, 1), std::invalid_argument);
}

// Removed at once, and never to come back: the newest one too.
TEST(RemoveKeyframe, GoesOnGrowing) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 5);
  map.update();
  map.remove_keyframe(4);
  EXPECT_EQ(map.newest(), 3);
  const int k = map.add_keyframe(observed_view(world, 9, scene_pose(5)), scene_pose(5));
  EXPECT_EQ(k, 5);
  for (int t = 0; t < map.num_tracks(); ++t) {
    if (!map.track(t).is_landmark()) continue;
    const Sight& known = map.track(t).sights.front();
    const float name =
        map.keyframe(known.keyframe).observed().frame.keypoints[known.keypoint].response;
    for (const int keypoint : map.keyframe(k).observed().minus.index)
      if (map.keyframe(k).observed().frame.keypoints[keypoint].response == name)
        map.add_sight(t, {k, keypoint});
  }
  EXPECT_EQ(map.update().reason, Reason::kNone);
  EXPECT_TRUE(same(map.pose(k), scene_pose(5), 0.05));
  expect_nothing_of(map, 4);
}

// Metres, where it was in units of the map: also what went before, which is carried.
TEST(RemoveKeyframe, WhatIsCarriedBecomesMetricToo) {
  const SyntheticStream world;
  Map map = scene(world);
  map.remove_keyframe(3);
  ASSERT_EQ(map.update().reason, Reason::kNone);
  const Rigid3 before = map.pose(3);
  map.make_metric(2.5);
  const double length = (map.pose(5).translation - map.pose(0).translation).norm();
  const auto known = AbsoluteObservation::length({0, 5}, length, 1e-3 * length);
  ASSERT_EQ(map.filter().add_absolute(known, false), Reason::kNone);
  ASSERT_EQ(map.update().reason, Reason::kNone);
  EXPECT_LT((map.pose(3).translation - 2.5 * before.translation).norm(), 0.01 * length);
}

TEST(RemoveKeyframe, TakesItsAbsoluteMeasurementsAlong) {
  const SyntheticStream world;
  Map map = scene(world);
  map.make_metric(1);
  const auto known = [&map](int k) {
    const double length = (map.pose(k).translation - map.pose(0).translation).norm();
    return AbsoluteObservation::length({0, k}, length, 1e-3 * length);
  };
  for (const int k : {3, 5}) EXPECT_EQ(map.filter().add_absolute(known(k), false), Reason::kNone);
  ASSERT_EQ(map.update().reason, Reason::kNone);
  EXPECT_TRUE(map.filter().has_absolute(3, AbsoluteObservation::Kind::kLength));
  map.remove_keyframe(3);
  EXPECT_FALSE(map.filter().has_absolute(3, AbsoluteObservation::Kind::kLength));
  EXPECT_TRUE(map.filter().has_absolute(5, AbsoluteObservation::Kind::kLength));
  ASSERT_EQ(map.update().reason, Reason::kNone);
  const auto of_removed = AbsoluteObservation::length({0, 3}, 1, 1);
  EXPECT_EQ(map.filter().add_absolute(of_removed, false), Reason::kMeasurementWithoutPose);
}

}  // namespace
}  // namespace eifmap::test
