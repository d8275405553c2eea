#include "map/map_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map/audit.h"
#include "mapper.h"
#include "simulation/feature_world.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

// Landmarks seen from exactly these keyframes of a scene.
void give(Map& map, const std::vector<int>& keyframes, int count) {
  for (int n = 0; n < count; ++n) {
    int track = -1;
    for (const int k : keyframes) {
      const std::vector<int>& taken = map.keyframe(k).track;
      const int keypoint =
          static_cast<int>(std::find(taken.begin(), taken.end(), kNoTrack) - taken.begin());
      ASSERT_LT(keypoint, static_cast<int>(taken.size()));
      if (track < 0)
        track = map.add_track({k, keypoint});
      else
        map.add_sight(track, {k, keypoint});
    }
    map.promote(track, {0, 0, 6}, Eigen::Matrix3d::Identity());
  }
}

TEST(MapBounds, KnowHowAMapHangsTogether) {
  const SyntheticStream world;
  Map map = make_scene(world, 6);
  EXPECT_EQ(map_structure(map), (MapStructure{6, 0}));
  give(map, {0, 1, 2}, 20);
  EXPECT_EQ(map_structure(map), (MapStructure{4, 0}));
  give(map, {2, 3, 4}, 20);  // through 2 alone
  EXPECT_EQ(map_structure(map), (MapStructure{2, 1}));
  EXPECT_EQ(map_structure(map, 2), (MapStructure{5, 0})) << "what is left has two sights";
  give(map, {1, 2, 3}, 20);
  EXPECT_EQ(map_structure(map), (MapStructure{2, 0}));
  give(map, {4, 5}, 100);  // of two sights: no scale
  EXPECT_EQ(map_structure(map), (MapStructure{2, 0}));
  give(map, {3, 4, 5}, 14);  // too few
  EXPECT_EQ(map_structure(map), (MapStructure{2, 0}));
  give(map, {3, 4, 5}, 1);
  EXPECT_EQ(map_structure(map), (MapStructure{1, 0}));
}

TEST(MapBounds, AKeyframeThatHoldsTheMapTogetherStays) {
  const SyntheticStream world;
  Map map = make_scene(world, 14);
  for (int k = 0; k + 2 < 14; ++k) give(map, {k, k + 1, k + 2}, 20);
  // All stand in a row, each needed: none can go.
  EXPECT_EQ(make_room(map, 13, {.max_keyframes = 14}), 0);
  // Seen all along, keyframe 3 is not.
  give(map, {1, 2, 3, 4, 5}, 40);
  const MapStructure before = map_structure(map);
  EXPECT_EQ(make_room(map, 13, {.max_keyframes = 14}), 1);
  EXPECT_TRUE(map.is_removed(3));
  EXPECT_EQ(map_structure(map), before);
  EXPECT_EQ(make_room(map, 13, {.max_keyframes = 14}), 0) << "there is room";
  EXPECT_EQ(make_room(map, 13, {.max_keyframes = 0}), 0) << "no bound";
}

TEST(MapBounds, LandmarksOfFewSightsGoFirst) {
  const SyntheticStream world;
  Map map = make_scene(world, 14);
  give(map, {0, 1, 2, 3}, 60);
  give(map, {0, 1}, 40);
  give(map, {12, 13}, 60);  // in view
  EXPECT_EQ(drop_landmarks(map, 13, {.max_landmarks = 160}), 0);
  EXPECT_EQ(drop_landmarks(map, 13, {.max_landmarks = 150}), 11);
  for (int t = 0; t < map.num_tracks(); ++t)
    EXPECT_TRUE(map.track(t).is_landmark() || (t >= 60 && t < 100)) << t;
  // A keyframe keeps thirty.
  drop_landmarks(map, 13, {.max_landmarks = 1});
  EXPECT_EQ(map.num_landmarks(), 60);
  EXPECT_TRUE(audit(map).empty());
}

// A walk of far more keyframes and landmarks than are allowed. No frame is lost by it, nor does the
// way bend.
TEST(MapBounds, HoldOnALongWalk) {
  const FeatureWorld world({.motion = "sideways", .num_frames = 240, .seed = 3});
  MapperOptions options;
  options.bound = {40, 600};
  options.keyframe.redundant_share = 2;  // the bound alone
  Mapper mapper(world.camera(), options);
  int full = 0, most_keyframes = 0, most_landmarks = 0;
  for (int i = 0; i < world.num_frames(); ++i) {
    const FrameResult result = mapper.process(world.frame(i).frame);
    full += result.reason == Reason::kMapFull;
    most_keyframes = std::max(most_keyframes, static_cast<int>(mapper.statistics().keyframes));
    most_landmarks = std::max(most_landmarks, static_cast<int>(mapper.statistics().landmarks));
    if (i % 20 == 19)
      for (const std::string& problem : mapper.audit()) ADD_FAILURE() << i << ": " << problem;
  }
  const MapperStatistics& statistics = mapper.statistics();
  EXPECT_LE(most_keyframes, 40);
  EXPECT_LE(most_landmarks, 600);
  EXPECT_GT(statistics.removed_keyframes, 20);
  EXPECT_GT(statistics.removed_landmarks, 100);
  EXPECT_GT(full, 50);
  EXPECT_EQ(statistics.starts, 1);
  EXPECT_EQ(statistics.losses, 0);
  const std::vector<TimedPose> trajectory = mapper.final_trajectory();
  ASSERT_EQ(trajectory.size(), 240u);
  EXPECT_EQ(mapper.keyframe_trajectory().size(), static_cast<std::size_t>(statistics.keyframes));
  // Of the whole way, once its start and its length are the truth's.
  const auto moved = [&](int i) {
    return (trajectory.front().world_from_camera.inverse() * trajectory[i].world_from_camera)
        .translation;
  };
  const auto truly_moved = [&](int i) {
    return (world.world_from_camera(0).inverse() * world.world_from_camera(i)).translation;
  };
  const double scale = truly_moved(239).norm() / moved(239).norm();
  for (int i = 0; i < 240; ++i)
    EXPECT_LT((scale * moved(i) - truly_moved(i)).norm(), 0.02 * truly_moved(239).norm()) << i;
}

// Every landmark gives way to another with its sights.
void renew_landmarks(Map& map) {
  const int tracks = map.num_tracks();
  for (int t = 0; t < tracks; ++t) {
    if (!map.track(t).is_landmark()) continue;
    const std::vector<Sight> sights = map.track(t).sights;
    const Eigen::Vector3d position = map.position(t);
    map.remove_track(t);
    const int renewed = map.add_track(sights.front());
    for (std::size_t s = 1; s < sights.size(); ++s) map.add_sight(renewed, sights[s]);
    map.promote(renewed, position, Eigen::Matrix3d::Identity());
  }
}

// Numbers of what is no more are not used again, and a camera that never rests uses up millions.
TEST(MapBounds, WhatWasRemovedIsNotHeld) {
  Map map = scene_with_landmarks(SyntheticStream(), 4);
  map.update();
  const auto in_use = static_cast<std::size_t>(map.num_landmarks());
  for (int round = 0; round < 30; ++round) {
    renew_landmarks(map);
    ASSERT_EQ(map.update().reason, Reason::kNone);
    if (round == 15) map.filter().scale_sigmas(1.1);  // looks at everything
  }
  EXPECT_TRUE(audit(map).empty());
  EXPECT_GT(map.num_landmarks(), static_cast<int>(in_use * 9 / 10));
  EXPECT_GT(map.num_tracks(), static_cast<int>(25 * in_use));
  const auto pieces = [in_use](std::size_t size) { return in_use / size + 3; };
  EXPECT_LE(map.tracks().num_pieces_held(), pieces(map.tracks().piece_size()));
  const FilterLandmarks& landmarks = map.filter().landmarks();
  EXPECT_LE(landmarks.num_pieces_held(), pieces(landmarks.piece_size()));
}

TEST(MapBounds, AreRefusedWhereNoMapCanLive) {
  MapperOptions options;
  options.bound.max_keyframes = 5;
  EXPECT_NE(options.problem().find("bound.max_keyframes"), std::string::npos);
  options.bound = {0, 10};
  EXPECT_NE(options.problem().find("bound.max_landmarks"), std::string::npos);
}

}  // namespace
}  // namespace eifmap::test
