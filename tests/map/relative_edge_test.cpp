// [WD10] III-A: a raw measurement is used in one relative pose only.
#include <gtest/gtest.h>

#include <algorithm>

#include "map/keyframe_insertion.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

int spent(const Map& map, int keyframe) {
  const auto& s = map.keyframe(keyframe).spent;
  return static_cast<int>(std::count(s.begin(), s.end(), 1));
}

TEST(RelativeEdge, SpendsEachMeasurementOnceAndOnlyOmegaP) {
  const SyntheticStream world;
  Map map = make_scene(world, 4);
  MapperOptions options;
  options.edge.min_measurements = 20;
  ASSERT_TRUE(add_edge_from_map(map, 0, 1, options));
  const int first = spent(map, 1);
  EXPECT_GE(first, 20);
  EXPECT_EQ(first, spent(map, 0));
  ASSERT_TRUE(add_edge_from_map(map, 1, 2, options));
  // Keyframe 1 belongs to both edges: what the second took was not taken before.
  EXPECT_EQ(spent(map, 1), first + spent(map, 2));
  for (int k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < map.keyframe(k).spent.size(); ++i)
      if (map.keyframe(k).spent[i]) {
        EXPECT_EQ(map.keyframe(k).observed().frame.keypoints[i].laplacian_sign, 1);
      }
  EXPECT_EQ(map.filter().num_edges(), 2);
}

TEST(RelativeEdge, OfferedTheSameMatchesAgainTakesOthers) {
  const SyntheticStream world;
  Map map = make_scene(world, 2);
  MapperOptions options;
  options.edge.min_measurements = 20;
  const ObservedFrame &i = map.keyframe(0).observed(), &j = map.keyframe(1).observed();
  const std::vector<Match> matches = match_omega_p(i, j, {});
  const Rigid3 i_from_j = scene_pose(0).inverse() * scene_pose(1);
  RelativePose start;
  start.i_from_j = i_from_j.rotation;
  start.direction = i_from_j.translation.normalized();
  ASSERT_TRUE(add_edge(map, 0, 1, matches, start, options));
  const int first = spent(map, 0);
  ASSERT_LT(first, static_cast<int>(matches.size()));
  if (add_edge(map, 0, 1, matches, start, options)) {
    EXPECT_GE(spent(map, 0), first + options.edge.min_measurements);
  } else {
    EXPECT_EQ(spent(map, 0), first);
  }
}

TEST(RelativeEdge, IsRefusedWhenTheMeasurementsAreSpent) {
  const SyntheticStream world;
  Map map = make_scene(world, 2);
  MapperOptions options;
  options.edge.min_measurements = 20;
  int edges = 0;
  while (edges < 50 && add_edge_from_map(map, 0, 1, options)) ++edges;
  EXPECT_GE(edges, 1);
  EXPECT_LT(edges, 20);  // the features run out
  EXPECT_EQ(map.filter().num_edges(), edges);
}

TEST(RelativeEdge, IsRefusedWhenTheDirectionIsUncertain) {
  const SyntheticStream world;
  Map map(synthetic_camera(), {});
  for (int i = 0; i < 2; ++i) {  // 1 cm apart, points at 4 m and more
    const Rigid3 pose({1, 0, 0, 0}, {0.01 * i, 0, 0});
    map.add_keyframe(observed_view(world, i, pose), pose);
  }
  MapperOptions options;
  options.edge.min_measurements = 20;
  EXPECT_FALSE(add_edge_from_map(map, 0, 1, options));
  EXPECT_EQ(spent(map, 0), 0);  // a refused edge spends nothing
}

TEST(RelativeEdge, AgreesWithTheTruth) {
  const SyntheticStream world(7);
  Map map = make_scene(world, 3);
  MapperOptions options;
  options.edge.min_measurements = 20;
  ASSERT_TRUE(add_edge_from_map(map, 0, 2, options));
  // The map's poses are the truth: a filter that finds the edge off drops it.
  EXPECT_EQ(map.filter().num_edges(), 1);
  for (int k = 0; k < 3; ++k) extend_tracks(map, k, options);
  EXPECT_EQ(map.update().dropped_edges, 0);
}

}  // namespace
}  // namespace eifmap::test
