#include "map/map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "map/keyframe_insertion.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

// Every link is there from both sides, and the filter holds exactly the landmarks' sights.
void expect_consistent(const Map& map) {
  std::size_t sights = 0, landmarks = 0;
  for (int t = 0; t < map.num_tracks(); ++t) {
    const Track& track = map.track(t);
    for (std::size_t k = 0; k < track.sights.size(); ++k) {
      const Sight& s = track.sights[k];
      EXPECT_EQ(map.keyframe(s.keyframe).track[s.keypoint], t);
      if (k > 0) {
        EXPECT_LT(track.sights[k - 1].keyframe, s.keyframe);
      }
    }
    if (!track.is_landmark()) continue;
    ++landmarks;
    sights += track.sights.size();
    EXPECT_EQ(map.filter().landmark(track.landmark).measurements.size(), track.sights.size());
  }
  EXPECT_EQ(map.num_landmarks(), static_cast<int>(landmarks));
  EXPECT_EQ(map.filter().num_measurements(), sights);
  for (int k = 0; k < map.num_keyframes(); ++k)
    for (std::size_t i = 0; i < map.keyframe(k).track.size(); ++i) {
      const int t = map.keyframe(k).track[i];
      if (t == kNoTrack) continue;
      const auto& linked = map.track(t).sights;
      EXPECT_TRUE(std::any_of(linked.begin(), linked.end(), [&](const Sight& s) {
        return s.keyframe == k && s.keypoint == static_cast<int>(i);
      }));
    }
}

TEST(Map, StaysConsistentThroughItsLife) {
  const SyntheticStream world;
  MapperOptions options;
  Map map = scene_with_landmarks(world, 5);
  expect_consistent(map);
  EXPECT_EQ(map.update().reason, Reason::kNone);
  expect_consistent(map);
  for (int k = 1; k < 5; ++k) extend_tracks(map, k, options);
  expect_consistent(map);
  map.update();
  for (int t = 0; t < map.num_tracks(); t += 3) map.remove_track(t);
  expect_consistent(map);
  for (int t = 1; t < map.num_tracks(); t += 3)
    if (!map.track(t).sights.empty()) map.remove_sight(t, map.track(t).sights.back().keyframe);
  expect_consistent(map);
}

// All the map's books.
std::string books(const Map& map) {
  std::ostringstream out;
  for (int t = 0; t < map.num_tracks(); ++t) {
    out << "\ntrack " << map.track(t).landmark;
    for (const Sight& s : map.track(t).sights) out << ' ' << s.keyframe << ',' << s.keypoint;
    if (map.track(t).is_landmark()) out << ' ' << map.position(t).transpose();
  }
  for (int k = 0; k < map.num_keyframes(); ++k) {
    out << "\nkeyframe " << map.keyframe(k).carrier << ' ' << map.pose(k).translation.transpose();
    for (const int t : map.keyframe(k).track) out << ' ' << t;
    for (const int spent : map.keyframe(k).spent) out << ' ' << spent;
  }
  for (const MapEdge& edge : map.edges()) out << "\nedge " << edge.i << ' ' << edge.j;
  return out.str();
}

TEST(Map, NothingThatHappensToACopyChangesTheOther) {
  const SyntheticStream world;
  const Map map = [&world] {
    Map made = scene_with_landmarks(world, 6);
    made.spend({1, 4, {{5, 9, 0}}});
    made.update();
    return made;
  }();
  const std::string before = books(map);
  const auto change = [&](auto&& what) {
    Map copy = map;
    EXPECT_EQ(books(copy), before);
    what(copy);
    expect_consistent(copy);
    EXPECT_NE(books(copy), before);
    EXPECT_EQ(books(map), before);
    expect_consistent(map);
  };
  change([](Map& m) { m.remove_track(3); });
  change([](Map& m) { m.remove_sight(5, m.track(5).sights.back().keyframe); });
  change([](Map& m) { m.remove_keyframe(4); });
  change([](Map& m) { m.spend({0, 2, {{7, 8, 0}}}); });
  change([](Map& m) { m.make_metric(3); });
  change([](Map& m) { extend_tracks(m, 2, MapperOptions()); });
  change([&world](Map& m) { m.add_keyframe(observed_view(world, 9, scene_pose(6)), Rigid3()); });
}

TEST(Map, RefusesASecondSightInAKeyframeAndASecondTrackOfAKeypoint) {
  const SyntheticStream world;
  Map map = make_scene(world, 2);
  const std::vector<int>& m0 = map.keyframe(0).observed().minus.index;
  const std::vector<int>& m1 = map.keyframe(1).observed().minus.index;
  const int a = map.add_track({0, m0[0]}), b = map.add_track({0, m0[1]});
  EXPECT_FALSE(map.add_sight(a, {0, m0[2]}));
  EXPECT_TRUE(map.add_sight(a, {1, m1[0]}));
  EXPECT_FALSE(map.add_sight(b, {1, m1[0]}));
}

TEST(Map, AWrongSightDoesNotKeepACandidateFromBecomingALandmark) {
  const SyntheticStream world;
  MapperOptions options;
  Map map = scene_with_landmarks(world, 5);
  map.update();
  // A candidate through keyframes 0 to 3 whose sight in keyframe 1 is another feature; keyframe 4
  // then extends it.
  const auto response = [&](int k, int keypoint) {
    return map.keyframe(k).observed().frame.keypoints[keypoint].response;
  };
  int tried = 0;
  for (int t = 0; t < map.num_tracks() && tried < 10; ++t) {
    if (map.track(t).sights.size() < 5) continue;
    const std::vector<Sight> sights = map.track(t).sights;
    const float name = response(0, sights[0].keypoint);
    map.remove_track(t);
    int wrong = -1;
    for (int keypoint : map.keyframe(1).observed().minus.index)
      if (map.keyframe(1).track[keypoint] == kNoTrack && response(1, keypoint) != name)
        wrong = keypoint;
    ASSERT_GE(wrong, 0);
    const int candidate = map.add_track(sights[0]);
    ASSERT_TRUE(map.add_sight(candidate, {1, wrong}));
    ASSERT_TRUE(map.add_sight(candidate, sights[2]));
    ASSERT_TRUE(map.add_sight(candidate, sights[3]));
    extend_tracks(map, 4, options);
    EXPECT_TRUE(map.track(candidate).is_landmark());
    EXPECT_TRUE(std::none_of(map.track(candidate).sights.begin(), map.track(candidate).sights.end(),
                             [](const Sight& s) { return s.keyframe == 1; }) ||
                response(1, map.track(candidate).sights[1].keypoint) == name);
    ++tried;
  }
  EXPECT_EQ(tried, 10);
}

TEST(Map, TakesPointsOfTwoViewsOnlyWhereFewAreTracked) {
  const SyntheticStream world;
  const MapperOptions options;
  for (const bool few : {false, true}) {
    Map map = scene_with_landmarks(world, 2);
    for (int t = 0; t < map.num_tracks(); t += 2) map.remove_track(t);
    map.update();
    const int promoted = extend_tracks(map, 1, options, {.few_tracked = few});
    if (few)
      EXPECT_GT(promoted, 10);
    else
      EXPECT_EQ(promoted, 0);
    expect_consistent(map);
  }
}

// A keyframe at scene_pose(6) whose landmarks are seen where they are, tracked to `tracked`.
Insertion insert_at(Map& map, const SyntheticStream& world, const Rigid3& tracked) {
  ObservedFrame observed = observed_view(world, 9, scene_pose(6));
  Tracking tracking;
  tracking.reason = Reason::kNone;
  tracking.reference = 4;
  tracking.world_from_camera = tracked;
  for (int t = 0; t < map.num_tracks(); ++t) {
    if (!map.track(t).is_landmark()) continue;
    const Sight& known = map.track(t).sights.front();
    const float name =
        map.keyframe(known.keyframe).observed().frame.keypoints[known.keypoint].response;
    for (int keypoint : observed.minus.index)
      if (observed.frame.keypoints[keypoint].response == name)
        tracking.sights.push_back({t, keypoint});
  }
  EXPECT_GT(tracking.sights.size(), 40u);
  return insert_keyframe(map, std::make_shared<const ObservedFrame>(std::move(observed)), tracking,
                         {}, {});
}

TEST(Map, AKeyframeThatTheFilterMovesFarIsAScaleJump) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 5);
  map.update();
  Map same = scene_with_landmarks(world, 5);
  same.update();
  EXPECT_EQ(insert_at(map, world, scene_pose(6)).reason, Reason::kNone);
  // Tracked to twice the distance, against all that its landmarks say.
  const Eigen::Vector3d from = scene_pose(4).translation, to = scene_pose(6).translation;
  const Rigid3 too_far(scene_pose(6).rotation, from + 2 * (to - from));
  EXPECT_EQ(insert_at(same, world, too_far).reason, Reason::kScaleJump);
}

TEST(Map, AKeyframeIsNotBuiltOnSand) {
  const SyntheticStream world;
  Map map = scene_with_landmarks(world, 5);
  map.update();
  MapperOptions options;
  Tracking tracking;
  tracking.reason = Reason::kNone;
  tracking.reference = 4;
  tracking.world_from_camera = scene_pose(6);
  tracking.covariance = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
  for (int t = 0; t < map.num_tracks(); ++t)
    if (map.track(t).is_landmark()) tracking.sights.push_back({t, 0});
  ASSERT_GT(static_cast<int>(tracking.sights.size()), options.keyframe.min_inliers);
  EXPECT_TRUE(wants_keyframe(map, tracking, {}, options));
  Tracking uncertain = tracking;  // half a unit, with a baseline of one
  uncertain.covariance *= 0.25e6;
  EXPECT_FALSE(wants_keyframe(map, uncertain, {}, options));
  Tracking few = tracking;
  few.sights.resize(static_cast<std::size_t>(options.keyframe.min_inliers) - 1);
  EXPECT_FALSE(wants_keyframe(map, few, {}, options));
  EXPECT_FALSE(wants_keyframe(map, tracking, {0, true}, options));
}

}  // namespace
}  // namespace eifmap::test
