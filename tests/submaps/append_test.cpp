// A map that is made in two parts, each in a gauge of its own, and put together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "map/audit.h"
#include "map/keyframe_insertion.h"
#include "map/map_scale.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

// The part's first keyframe is its frame, and its first baseline has another length than in the
// world.
Similarity part_from_world(int first) {
  Similarity scaled;
  scaled.scale = 1.7;
  return scaled * Similarity::of(scene_pose(first)).inverse();
}

float name_of(const Map& map, const Sight& sight) {
  return map.keyframe(sight.keyframe).observed().frame.keypoints[sight.keypoint].response;
}

// Views first to last of the scene, mapped as one map; points from two views or more.
Map mapped(const SyntheticStream& world, int first, int last) {
  const Similarity from_world = part_from_world(first);
  Map map(synthetic_camera(), MapperOptions());
  std::map<float, std::vector<Sight>> sights;
  for (int i = first; i <= last; ++i) {
    const Rigid3 pose = (from_world * Similarity::of(scene_pose(i))).rigid();
    const int k = map.add_keyframe(observed_view(world, i, scene_pose(i)), pose);
    for (const int keypoint : map.keyframe(k).observed().minus.index)
      sights[name_of(map, {k, keypoint})].push_back({k, keypoint});
  }
  for (const auto& [name, seen] : sights) {
    if (seen.size() < 3) continue;
    const int track = map.add_track(seen.front());
    for (std::size_t s = 1; s < seen.size(); ++s) map.add_sight(track, seen[s]);
    const ObservedFrame& observed = map.keyframe(seen.front().keyframe).observed();
    const Eigen::Vector3d in_first = 6 * observed.x[seen.front().keypoint].homogeneous();
    const Rigid3 first_pose = scene_pose(first + seen.front().keyframe);
    map.promote(track, from_world * (first_pose * in_first), Eigen::Matrix3d::Identity());
  }
  EXPECT_EQ(map.update().reason, Reason::kNone);
  EXPECT_EQ(map.update().reason, Reason::kNone);
  return map;
}

// As the truth of the view that the part begins with says; the first baselines have the lengths
// that they have in the world.
Similarity world_from_part(int first) {
  return part_from_world(0) * part_from_world(first).inverse();
}

void expect_sound(const Map& map) {
  for (const std::string& problem : audit(map)) ADD_FAILURE() << problem;
}

// Whitened errors of a map's landmarks, in the order of tracks.
std::vector<double> errors_of(const Map& map, int first_track, int tracks) {
  std::vector<double> errors;
  for (int t = first_track; t < first_track + tracks; ++t) {
    if (!map.track(t).is_landmark()) continue;
    const int landmark = map.track(t).landmark;
    std::vector<std::pair<int, double>> of_landmark;
    for (const PointMeasurement& m : map.filter().landmark(landmark).measurements)
      of_landmark.emplace_back(m.pose, map.filter().error(landmark, m));
    std::sort(of_landmark.begin(), of_landmark.end());
    for (const auto& [pose, error] : of_landmark) errors.push_back(error);
  }
  return errors;
}

// Of the tracks that show the same point one is left.
int join_same_points(Map& map, int first_track) {
  std::map<float, int> by_name;
  for (int t = 0; t < first_track; ++t)
    if (map.track(t).is_landmark()) by_name[name_of(map, map.track(t).sights.front())] = t;
  int joined = 0;
  for (int t = first_track; t < map.num_tracks(); ++t) {
    if (!map.track(t).is_landmark()) continue;
    const auto same = by_name.find(name_of(map, map.track(t).sights.front()));
    if (same != by_name.end()) joined += map.join_tracks(same->second, t) ? 1 : 0;
  }
  return joined;
}

void settle(Map& map) {
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(map.filter().iterate_whole().ok);
  ASSERT_EQ(map.update().reason, Reason::kNone);
}

TEST(Append, SeesWhatBothSaw) {
  const SyntheticStream world;
  Map map = mapped(world, 0, 3), other = mapped(world, 4, 8);
  ASSERT_TRUE(add_edge_from_map(other, 0, 2, MapperOptions()));
  other.remove_keyframe(3);
  ASSERT_EQ(other.update().reason, Reason::kNone);
  const Map before = map;
  Similarity where = world_from_part(4);
  where.scale = 0.6;
  const Appended appended = map.append(other, where);
  EXPECT_EQ(appended.first_keyframe, 4);
  EXPECT_EQ(appended.first_track, before.num_tracks());
  EXPECT_EQ(appended.growth, 0.6);
  EXPECT_EQ(map.num_keyframes(), 9);
  EXPECT_EQ(map.num_keyframes_in_use(), 8);
  EXPECT_TRUE(map.is_removed(7));
  EXPECT_EQ(map.keyframe(7).carrier, 4 + other.keyframe(3).carrier);
  EXPECT_NEAR((map.pose(7).translation - where * other.pose(3).translation).norm(), 0, 1e-9);
  EXPECT_EQ(map.num_landmarks(), before.num_landmarks() + other.num_landmarks());
  EXPECT_EQ(map.filter().num_edges(), before.filter().num_edges() + other.filter().num_edges());
  EXPECT_EQ(map.filter().num_measurements(),
            before.filter().num_measurements() + other.filter().num_measurements());
  EXPECT_EQ(map.epoch(), before.epoch() + other.epoch() + 1);
  expect_sound(map);
  EXPECT_EQ(errors_of(map, 0, before.num_tracks()), errors_of(before, 0, before.num_tracks()));
  const std::vector<double> now = errors_of(map, appended.first_track, other.num_tracks());
  const std::vector<double> then = errors_of(other, 0, other.num_tracks());
  ASSERT_EQ(now.size(), then.size());
  ASSERT_GT(now.size(), 300u);
  for (std::size_t k = 0; k < now.size(); ++k) EXPECT_NEAR(now[k], then[k], 1e-6 * (1 + then[k]));
}

// What the two parts share once it is joined is all that a map made as one would know.
TEST(Append, IsAsCertainAsAMapMadeAsOne) {
  const SyntheticStream world;
  Map map = mapped(world, 0, 3);
  const Map other = mapped(world, 4, 8);
  Map whole = mapped(world, 0, 8);
  const Appended appended = map.append(other, world_from_part(4));
  ASSERT_GT(join_same_points(map, appended.first_track), 50);
  settle(map);
  expect_sound(map);
  // The same sights, where the one has not more of them.
  for (int t = 0; t < whole.num_tracks(); ++t) {
    const std::vector<Sight> seen = whole.track(t).sights;
    for (const Sight& s : seen)
      if (map.keyframe(s.keyframe).track[s.keypoint] == kNoTrack) whole.remove_sight(t, s.keyframe);
    if (whole.track(t).is_landmark() && whole.track(t).sights.size() < 2) whole.remove_track(t);
  }
  for (int t = 0; t < map.num_tracks(); ++t) {
    const std::vector<Sight> seen = map.track(t).sights;
    for (const Sight& s : seen)
      if (whole.keyframe(s.keyframe).track[s.keypoint] == kNoTrack) map.remove_sight(t, s.keyframe);
    if (map.track(t).is_landmark() && map.track(t).sights.size() < 2) map.remove_track(t);
  }
  settle(whole);
  settle(map);
  ASSERT_EQ(map.filter().num_measurements(), whole.filter().num_measurements());
  for (int k = 1; k < 9; ++k) {
    PoseBlock of_map, of_whole;
    ASSERT_TRUE(map.filter().pose_covariance(k, of_map));
    ASSERT_TRUE(whole.filter().pose_covariance(k, of_whole));
    EXPECT_LT((of_map - of_whole).norm(), 0.02 * of_whole.norm()) << k;
    EXPECT_NEAR((map.pose(k).translation - whole.pose(k).translation).norm(), 0, 1e-3) << k;
  }
}

TEST(Append, IsTheSameToTheBitEachTime) {
  const SyntheticStream world;
  const auto made = [&world] {
    Map map = mapped(world, 0, 3);
    const Map other = mapped(world, 4, 8);
    join_same_points(map, map.append(other, world_from_part(4)).first_track);
    settle(map);
    return map;
  };
  const Map first = made(), second = made();
  for (int k = 0; k < first.num_keyframes(); ++k) {
    EXPECT_EQ(first.pose(k).translation, second.pose(k).translation);
    EXPECT_EQ(first.pose(k).rotation.coeffs(), second.pose(k).rotation.coeffs());
  }
}

TEST(Append, RefusesWhatItCannotTake) {
  const SyntheticStream world;
  Map map = mapped(world, 0, 3);
  Map other = mapped(world, 4, 8);
  Similarity where;
  where.scale = 0;
  EXPECT_THROW(map.append(other, where), std::invalid_argument);
  other.scale().waiting.emplace_back();
  EXPECT_TRUE(other.is_measured());
  EXPECT_THROW(map.append(other, Similarity()), std::invalid_argument);
  EXPECT_EQ(map.num_keyframes(), 4);
}

}  // namespace
}  // namespace eifmap::test
