#include "map/sight_counts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map/keyframe_insertion.h"
#include "support/feature_world.h"

namespace eifmap::test {
namespace {

Rigid3 beside(double x) {
  return {Eigen::Quaterniond::Identity(), {x, 0, 0}};
}

ObservedFrame observed_at(int i, double x) {
  return observe(SyntheticStream().view(i, beside(x)), synthetic_camera(), MapSign::kMinus, 2);
}

// Two keyframes that are 0.5 apart, and what both see.
Map two_keyframes() {
  Map map(synthetic_camera(), {});
  for (const double x : {0.0, 0.5})
    map.add_keyframe(observed_at(map.num_keyframes(), x), beside(x));
  const ObservedFrame &a = map.keyframe(0).observed(), &b = map.keyframe(1).observed();
  for (const Match& m : match_omega_m(a, b, {})) {
    const int track = map.add_track({0, m.a});
    map.add_sight(track, {1, m.b});
    const double depth = 0.5 / (a.x[m.a].x() - b.x[m.b].x());
    map.promote(track, depth * a.x[m.a].homogeneous(), 0.01 * Eigen::Matrix3d::Identity());
  }
  return map;
}

std::vector<int> all_tracks(const Map& map) {
  std::vector<int> all;
  for (int t = 0; t < map.num_tracks(); ++t) all.push_back(t);
  return all;
}

// From `x` everything is looked for, and all seen but every `missed`-th track.
Tracking tracked_at(const Map& map, double x, int missed) {
  Tracking tracking;
  tracking.reason = Reason::kNone;
  tracking.world_from_camera = beside(x);
  tracking.looked_for = all_tracks(map);
  for (const int t : tracking.looked_for)
    if ((t + 1) % missed != 0) tracking.sights.push_back({t, 0});
  return tracking;
}

TEST(SightCounts, FindWhatIsHardlySeen) {
  const Map map = two_keyframes();
  ASSERT_GT(map.num_landmarks(), 100);
  SightCounts counts(synthetic_camera());
  for (int i = 0; i < 11; ++i) counts.add(map, tracked_at(map, 0.06 * i, 5));
  EXPECT_TRUE(counts.hardly_seen(map).empty()) << "judged too early";
  for (int i = 11; i < 16; ++i) counts.add(map, tracked_at(map, 0.06 * i, 5));
  const std::vector<int> hardly_seen = counts.hardly_seen(map);
  EXPECT_GT(static_cast<int>(hardly_seen.size()), map.num_landmarks() / 5 * 7 / 10);
  for (const int t : hardly_seen) EXPECT_EQ((t + 1) % 5, 0);
}

TEST(SightCounts, LeaveWhatIsSeenEveryThirdTime) {
  const Map map = two_keyframes();
  SightCounts counts(synthetic_camera());
  for (int i = 0; i < 30; ++i)
    counts.add(map, i % 3 == 0 ? tracked_at(map, 0.06 * i, 1000000) : tracked_at(map, 0.06 * i, 5));
  EXPECT_TRUE(counts.hardly_seen(map).empty());
}

TEST(SightCounts, StandingStillTellsNothingNew) {
  const Map map = two_keyframes();
  SightCounts counts(synthetic_camera());
  for (int i = 0; i < 100; ++i) counts.add(map, tracked_at(map, 0.2 + 0.001 * (i % 2), 5));
  EXPECT_TRUE(counts.hardly_seen(map).empty());
}

TEST(SightCounts, ExpectWhatLooksAsItDid) {
  const Map map = two_keyframes();
  const SafeView view(synthetic_camera());
  const std::vector<int> all = all_tracks(map);
  const auto expected = [&](const Rigid3& pose) {
    return landmarks_expected(map, view, pose, all).size();
  };
  EXPECT_GT(expected(beside(0.25)), all.size() * 7 / 10);
  EXPECT_EQ(expected({so3_exp({0, M_PI, 0}), {0, 0, 0}}), 0u) << "behind";
  EXPECT_LE(expected({Eigen::Quaterniond::Identity(), {0, 0, 4}}), 2u) << "three times as large";
  EXPECT_EQ(expected({Eigen::Quaterniond::Identity(), {0, 0, -12}}), 0u) << "a third as large";
  // About the points' middle, and looking at it.
  const Eigen::Quaterniond turn = so3_exp({0, 50 * M_PI / 180, 0});
  const Eigen::Vector3d middle(0, 0, 6);
  EXPECT_LT(expected({turn, middle - turn * middle}), all.size() / 5) << "from another side";
}

TEST(SightCounts, ALensDoesNotFoldWhatIsOutOfViewBackIntoIt) {
  Camera camera = synthetic_camera();
  camera.model = CameraModel::kRadialTangential;
  camera.distortion = {-0.28, 0.07, 0, 0, 0};
  const SafeView view(camera);
  EXPECT_TRUE(view.contains({0, 0}));
  for (const double far : {1.0, 1.5, 2.0, 3.0, 5.0}) {
    EXPECT_FALSE(view.contains({far, 0}));
    EXPECT_FALSE(view.contains({0, -far}));
  }
}

TEST(SightCounts, AKeyframeTakesOutWhatWasHardlySeen) {
  for (const bool hardly : {false, true}) {
    Map map = two_keyframes();
    const std::vector<int> gone = hardly ? std::vector<int>{3, 7, 12} : std::vector<int>{};
    Tracking tracking;
    tracking.reason = Reason::kNone;
    tracking.reference = tracking.related = 1;
    tracking.world_from_camera = beside(0.6);
    insert_keyframe(map, std::make_shared<const ObservedFrame>(observed_at(2, 0.6)), tracking, gone,
                    {});
    for (const int t : {3, 7, 12}) EXPECT_EQ(map.track(t).is_landmark(), !hardly);
  }
}

}  // namespace
}  // namespace eifmap::test
