// A map that is put elsewhere as a whole, and tracks that turn out to be one.
#include <gtest/gtest.h>

#include <stdexcept>

#include "map/audit.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

std::vector<Similarity> nodes_of(const Map& map) {
  std::vector<Similarity> nodes;
  for (int k = 0; k < map.num_keyframes(); ++k) nodes.push_back(Similarity::of(map.pose(k)));
  return nodes;
}

void expect_sound(const Map& map) {
  for (const std::string& problem : audit(map)) ADD_FAILURE() << problem;
}

// One similarity for all but the first: every image stays, and so does what is seen in it.
TEST(Bend, KeepsWhatKeyframesSee) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 6);
  map.update();
  map.remove_keyframe(4);
  map.update();
  const int carrier = map.keyframe(4).carrier;
  const Rigid3 carrier_from_removed = map.pose(carrier).inverse() * map.pose(4);
  std::vector<Similarity> nodes = nodes_of(map);
  for (int k = 1; k < 6; ++k) nodes[k].scale = 1.1;
  const Map before = map;
  const std::vector<double> growth = map.bend(nodes);
  EXPECT_EQ(map.epoch(), before.epoch() + 1);
  EXPECT_EQ(growth.size(), 6u);
  EXPECT_EQ(growth[4], growth[carrier]);
  for (int t = 0; t < map.num_tracks(); ++t) {
    if (!map.track(t).is_landmark()) continue;
    const std::vector<Sight>& sights = map.track(t).sights;
    const int k = sights[sights.size() / 2].keyframe;
    const Eigen::Vector3d seen = map.pose(k).inverse() * map.position(t);
    const Eigen::Vector3d then = before.pose(k).inverse() * before.position(t);
    EXPECT_NEAR((seen - growth[k] * then).norm(), 0, 1e-9) << t;
  }
  const Rigid3 now = map.pose(carrier).inverse() * map.pose(4);
  EXPECT_NEAR((now.translation - growth[carrier] * carrier_from_removed.translation).norm(), 0,
              1e-9);
  expect_sound(map);
}

TEST(Bend, IsUndoneByTheSights) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 6);
  map.update();
  map.update();
  const Map before = map;
  std::vector<Similarity> nodes = nodes_of(map);
  for (int k = 2; k < 6; ++k) {
    nodes[k].scale = 1 + 0.01 * k;
    nodes[k].translation += Eigen::Vector3d(0.01 * k, 0.005 * k, -0.01);
  }
  map.bend(nodes);
  EXPECT_EQ(map.update().reason, Reason::kNone);
  map.update();
  for (int k = 0; k < 6; ++k)
    EXPECT_LT((map.pose(k).translation - before.pose(k).translation).norm(), 2e-3) << k;
}

TEST(Bend, RefusesWhatMakesNoSense) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 3);
  map.update();
  std::vector<Similarity> nodes = nodes_of(map);
  nodes.pop_back();
  EXPECT_THROW(map.bend(nodes), std::invalid_argument);
  nodes = nodes_of(map);
  nodes[1].scale = 0;
  EXPECT_THROW(map.bend(nodes), std::invalid_argument);
}

// A landmark whose second half was taken for another: joined, it is as it was.
TEST(JoinTracks, GivesAllSightsToOne) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 6);
  map.update();
  const Map whole = map;
  int kept = 0;
  while (map.track(kept).sights.size() < 6) ++kept;
  const std::vector<Sight> sights = map.track(kept).sights;
  for (int k = 3; k < 6; ++k) map.remove_sight(kept, k);
  const int gone = map.add_track(sights[3]);
  map.add_sight(gone, sights[4]);
  map.add_sight(gone, sights[5]);
  map.promote(gone, map.position(kept), Eigen::Matrix3d::Identity());
  const int landmarks = map.num_landmarks();
  EXPECT_FALSE(map.join_tracks(kept, kept));
  EXPECT_TRUE(map.join_tracks(kept, gone));
  EXPECT_EQ(map.num_landmarks(), landmarks - 1);
  EXPECT_TRUE(map.track(gone).sights.empty());
  EXPECT_EQ(map.track(kept).sights.size(), 6u);
  EXPECT_EQ(map.filter().num_measurements(), whole.filter().num_measurements());
  expect_sound(map);
  map.update();
  EXPECT_LT((map.position(kept) - whole.position(kept)).norm(), 1e-3);
}

TEST(JoinTracks, RefusesTwoThatAreSeenAtOnce) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 4);
  map.update();
  const Map before = map;
  EXPECT_FALSE(map.join_tracks(0, 1));
  EXPECT_EQ(map.num_landmarks(), before.num_landmarks());
  EXPECT_EQ(map.track(0).sights.size(), before.track(0).sights.size());
  expect_sound(map);
}

}  // namespace
}  // namespace eifmap::test
