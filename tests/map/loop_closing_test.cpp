// A camera that goes to the right and comes back: what it sees on its way back is what it has seen
// before, and the map has it twice.
#include "map/loop_closing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "geometry/triangulation.h"
#include "map/audit.h"
#include "map/loop_gate.h"
#include "map/loop_graph.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

constexpr int kThere = 30;  // keyframes on the way there
constexpr int kKeyframes = 2 * kThere;

// Its way back is a little nearer to what it sees.
Rigid3 true_pose(int k) {
  const bool back = k >= kThere;
  const int at = back ? kKeyframes - 1 - k : k;
  return {so3_exp({0, 0.005 * at, 0}), {0.6 * at - 6, back ? 0.1 : 0, back ? 0.2 : 0}};
}

MapperOptions test_options() {
  MapperOptions options;
  options.loop.enabled = true;
  options.loop.min_gap = 10;
  return options;
}

// A feature's track goes on for as long as each keyframe sees it, and is another one afterwards.
Map map_along(int keyframes, const std::function<Rigid3(int)>& pose_of,
              const std::function<ObservedFrame(int)>& view) {
  Map map(synthetic_camera(), test_options());
  std::map<float, int> tracks;  // by what is seen
  for (int k = 0; k < keyframes; ++k) {
    map.add_keyframe(view(k), pose_of(k));
    std::map<float, int> now;
    for (const int keypoint : map.keyframe(k).observed().minus.index) {
      const float which = map.keyframe(k).observed().frame.keypoints[keypoint].response;
      const auto before = tracks.find(which);
      if (before != tracks.end() && map.add_sight(before->second, {k, keypoint}))
        now[which] = before->second;
      else
        now[which] = map.add_track({k, keypoint});
    }
    tracks = std::move(now);
  }
  for (int t = 0; t < map.num_tracks(); ++t) {
    const std::vector<Sight>& sights = map.track(t).sights;
    if (sights.size() < 3) continue;
    std::vector<Sighting> seen;
    for (const Sight& s : sights) {
      const ObservedFrame& observed = map.keyframe(s.keyframe).observed();
      seen.push_back({map.pose(s.keyframe), observed.x[s.keypoint], observed.sigma[s.keypoint]});
    }
    const TriangulatedPoint point = triangulate(seen);
    if (point.valid) map.promote(t, point.point, point.covariance);
  }
  map.update();
  map.update();
  return map;
}

// What is seen on the way back is off by this similarity, that gathers on the way.
void drift(Map& map, const Eigen::Vector3d& turn, const Eigen::Vector3d& shift, double growth) {
  std::vector<Similarity> nodes;
  for (int k = 0; k < map.num_keyframes(); ++k) {
    const double share = k < 2 ? 0 : static_cast<double>(k) / (map.num_keyframes() - 1);
    nodes.push_back(Similarity::of({so3_exp(share * turn), share * shift}) *
                    Similarity::of(map.pose(k), std::pow(growth, share)));
  }
  map.bend(nodes);
}

double off(const Map& map, int k) {
  return (map.pose(k).translation - true_pose(k).translation).norm();
}

const Map& scene() {
  static const SyntheticStream world;
  static const Map map =
      map_along(kKeyframes, true_pose, [](int k) { return observed_view(world, k, true_pose(k)); });
  return map;
}

TEST(LoopSearch, LooksForWhatIsOldAndUnconnected) {
  const Map& map = scene();
  const int newest = map.newest();
  const std::vector<char> allowed = may_close(map, newest, test_options().loop);
  EXPECT_TRUE(allowed[0] && allowed[2]);
  EXPECT_FALSE(allowed[newest] || allowed[newest - 5]);
  for (int k = 0; k < map.num_keyframes(); ++k)
    EXPECT_FALSE(map.num_shared(newest)[k] > 0 && allowed[k]) << k;
  std::vector<char> tried(allowed.size(), 0);
  for (int turn = 0; turn < 60; ++turn)
    for (const int k : places_by_position(map, newest, allowed, turn, 4)) tried[k] = 1;
  EXPECT_EQ(tried, allowed) << "each is tried some time";
}

TEST(LoopSearch, WantsSeveralKeyframesInARow) {
  const Map& map = scene();
  const MapperOptions options = test_options();
  LoopSearch search;
  const int newest = map.newest();
  EXPECT_FALSE(search.look(map, newest - 2, {2}, options));
  EXPECT_FALSE(search.look(map, newest - 1, {1}, options));
  const std::optional<int> found = search.look(map, newest, {0}, options);
  ASSERT_TRUE(found);
  EXPECT_LT(*found, 4);
  search.begin_anew();
  EXPECT_FALSE(search.look(map, newest - 1, {1}, options));
  EXPECT_FALSE(search.look(map, kThere + 4, {}, options)) << "it sees nothing of it";
  EXPECT_FALSE(search.look(map, newest, {0}, options)) << "it begins anew";
}

TEST(LoopGate, FindsPoseAndScaleAgainstTheOldPlace) {
  Map map = scene();
  drift(map, {0, 0.02, 0}, {0.1, 0.05, 0}, 1.05);
  const int newest = map.newest();
  LoopFit fit = fit_loop(map, 1, newest, test_options());
  ASSERT_TRUE(fit.ok()) << fit.detail;
  EXPECT_NEAR(fit.world_from_newest.scale, 1 / 1.05, 0.01);
  const Rigid3 found = map.pose(1).inverse() * fit.world_from_newest.rigid();
  const Rigid3 truth = true_pose(1).inverse() * true_pose(newest);
  EXPECT_LT((found.translation - truth.translation).norm(), 0.05);
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 0.01);
  check_only_place(map, test_options(), fit);
  EXPECT_TRUE(fit.ok()) << fit.detail;
}

TEST(LoopGate, RefusesAPlaceThatHasNothingOfIt) {
  const Map& map = scene();
  EXPECT_EQ(fit_loop(map, kThere - 3, map.newest(), test_options()).reason,
            Reason::kLoopTooFewInliers);
}

TEST(LoopGate, RefusesWhatTheFilterKnowsToBeImpossible) {
  MapperOptions options = test_options();
  options.loop.drift_share = 0;
  Map map = scene();
  LoopFit fit = fit_loop(map, 1, map.newest(), options);
  check_possible(map, options.loop, fit);
  EXPECT_TRUE(fit.ok()) << fit.detail;
  fit.world_from_newest.translation += Eigen::Vector3d(2, 0, 0);
  check_possible(map, options.loop, fit);
  EXPECT_EQ(fit.reason, Reason::kLoopImpossible);
  LoopFit grown = fit_loop(map, 1, map.newest(), options);
  grown.world_from_newest.scale = 2;
  check_possible(map, options.loop, grown);
  EXPECT_EQ(grown.reason, Reason::kLoopImpossible);
}

// Of three rooms side by side with the same in each: what a camera sees of the first, and of the
// others as if these were where the first one is.
constexpr double kRoom = 22;  // m

ObservedFrame view_of_rooms(const SyntheticStream& room, int k, const Rigid3& pose) {
  constexpr int kPoints = 1000;  // more than there are in a room
  FeatureFrame all;
  for (int copy = 0; copy < 3; ++copy) {
    const Rigid3 in_room(pose.rotation, pose.translation - Eigen::Vector3d(copy * kRoom, 0, 0));
    FeatureFrame seen = room.view(k, in_room);
    for (Keypoint& keypoint : seen.keypoints)
      keypoint.response = 1 / (1 / keypoint.response + static_cast<float>(copy * kPoints));
    seen.keypoints.insert(seen.keypoints.begin(), all.keypoints.begin(), all.keypoints.end());
    seen.descriptors.insert(seen.descriptors.begin(), all.descriptors.begin(),
                            all.descriptors.end());
    all = std::move(seen);
  }
  return observe(all, synthetic_camera(), MapSign::kMinus, MapperOptions().sigma_factor);
}

// Past all of them: the third is like the first and like the second.
const Map& three_rooms() {
  constexpr int kOfRoom = 28;  // keyframes
  static const SyntheticStream room;
  const auto pose_of = [](int k) { return Rigid3({1, 0, 0, 0}, {kRoom / kOfRoom * k, 0, 0}); };
  static const Map map = map_along(2 * kOfRoom + 3, pose_of,
                                   [&](int k) { return view_of_rooms(room, k, pose_of(k)); });
  return map;
}

LoopOutcome close(Map& map, const MapperOptions& options) {
  LoopSearch search;
  LoopOutcome outcome;
  for (int k = map.newest() - 4; k <= map.newest() && !outcome.found; ++k)
    outcome = close_loop(map, map.newest(), search, options);
  return outcome;
}

TEST(LoopClosing, BringsADriftedMapBackAndJoinsWhatItHasTwice) {
  Map map = scene();
  drift(map, {0, 0.02, 0}, {0.1, 0.05, 0}, 1.05);
  const int newest = map.newest(), landmarks = map.num_landmarks(), epoch = map.epoch();
  EXPECT_GT(off(map, newest), 0.1);
  const LoopOutcome outcome = close(map, test_options());
  ASSERT_TRUE(outcome.found);
  EXPECT_EQ(outcome.reason, Reason::kNone) << outcome.detail;
  EXPECT_EQ(outcome.growth.size(), static_cast<std::size_t>(map.num_keyframes()));
  EXPECT_LT(off(map, newest), 0.05);
  EXPECT_GT(outcome.joined, 50);
  EXPECT_LT(map.num_landmarks(), landmarks - 30);
  EXPECT_EQ(map.epoch(), epoch + 1);
  for (const std::string& problem : audit(map)) ADD_FAILURE() << problem;
  EXPECT_FALSE(may_close(map, newest, test_options().loop)[1]) << "the passes are connected now";
}

// Both passes agree already: nothing is to be bent.
TEST(LoopClosing, OnlyJoinsWhatAgrees) {
  Map map = scene();
  const Map before = map;
  const LoopOutcome outcome = close(map, test_options());
  ASSERT_TRUE(outcome.closed()) << outcome.detail;
  EXPECT_TRUE(outcome.growth.empty());
  EXPECT_GT(outcome.joined, 50);
  EXPECT_EQ(map.epoch(), before.epoch());
  PoseBlock now, then;
  ASSERT_TRUE(map.filter().pose_covariance(map.newest(), now) &&
              before.filter().pose_covariance(map.newest(), then));
  EXPECT_LT(now.trace(), 0.8 * then.trace()) << "the loop says where it is";
  for (const std::string& problem : audit(map)) ADD_FAILURE() << problem;
}

TEST(LoopClosing, LeavesTheMapWhereItRefuses) {
  Map map = scene();
  MapperOptions options = test_options();
  options.loop.min_inliers = 10000;
  const LoopOutcome outcome = close(map, options);
  EXPECT_TRUE(outcome.found);
  EXPECT_EQ(outcome.reason, Reason::kLoopTooFewInliers);
  EXPECT_EQ(map.num_landmarks(), scene().num_landmarks());
  EXPECT_EQ(map.epoch(), scene().epoch());
  for (int k = 0; k < map.num_keyframes(); ++k)
    EXPECT_EQ(map.pose(k).translation, scene().pose(k).translation);
}

TEST(LoopGate, RefusesAPlaceThatIsNotTheOnlyOne) {
  const Map& map = three_rooms();
  for (const int old : {2, 30}) {
    LoopFit fit = fit_loop(map, old, map.newest(), test_options());
    ASSERT_TRUE(fit.ok()) << fit.detail;
    EXPECT_NEAR((fit.world_from_newest.translation - map.pose(old).translation).norm(), 0, 0.05);
    check_only_place(map, test_options(), fit);
    EXPECT_EQ(fit.reason, Reason::kLoopAmbiguous) << fit.detail;
  }
}

// Where the filter cannot tell rooms apart either, for the way may be off by as much as it is long.
TEST(LoopClosing, LeavesTheMapWhereAnotherPlaceLooksTheSame) {
  Map map = three_rooms();
  MapperOptions options = test_options();
  options.loop.drift_share = 1;
  const LoopOutcome outcome = close(map, options);
  EXPECT_TRUE(outcome.found);
  EXPECT_EQ(outcome.reason, Reason::kLoopAmbiguous) << outcome.detail;
  EXPECT_EQ(map.num_landmarks(), three_rooms().num_landmarks());
  EXPECT_EQ(map.epoch(), three_rooms().epoch());
  for (int k = 0; k < map.num_keyframes(); ++k)
    EXPECT_EQ(map.pose(k).translation, three_rooms().pose(k).translation);
}

TEST(LoopGraph, AsItIsHasNoErrorButTheLoops) {
  const Map& map = scene();
  const LoopFit fit = fit_loop(map, 1, map.newest(), test_options());
  PoseGraph graph = graph_with_loop(map, fit);
  graph.edges.pop_back();
  EXPECT_NEAR(graph.cost(), 0, 1e-9);
  EXPECT_TRUE(solve(graph).ok);
}

}  // namespace
}  // namespace eifmap::test
