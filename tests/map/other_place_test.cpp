#include "map/other_place.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/triangulation.h"
#include "map/tracking.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

const Rigid3 kLast(scene_pose(1).rotation, {0.70, 0, 0});  // where the camera was
const Rigid3 kNear(scene_pose(1).rotation, {0.75, 0, 0});
const Rigid3 kFar(scene_pose(1).rotation, {1.40, 0, 0});  // what is in 7 m is 50 px elsewhere

// Two keyframes of one place, and every `nth` landmark of what they have in common.
void add_place(const SyntheticStream& world, const Rigid3& place, int nth, Map& map) {
  const int a = map.add_keyframe(observed_view(world, 0, scene_pose(0)), place * scene_pose(0));
  const int b = map.add_keyframe(observed_view(world, 1, scene_pose(1)), place * scene_pose(1));
  const ObservedFrame& first = map.keyframe(a).observed();
  const ObservedFrame& second = map.keyframe(b).observed();
  int number = 0;
  for (const Match& m : match_omega_m(first, second, MatchOptions())) {
    const Sighting sightings[] = {{map.pose(a), first.x[m.a], first.sigma[m.a]},
                                  {map.pose(b), second.x[m.b], second.sigma[m.b]}};
    const TriangulatedPoint point = triangulate(sightings);
    if (!point.valid || number++ % nth != 0) continue;
    const int track = map.add_track({a, m.a});
    map.add_sight(track, {b, m.b});
    map.promote(track, point.point, point.covariance);
  }
}

Map one_place(const SyntheticStream& world) {
  Map map(synthetic_camera(), {});
  add_place(world, Rigid3(), 1, map);
  return map;
}

int point_of(const Keypoint& keypoint) {  // SyntheticStream gives it away
  return static_cast<int>(std::lround(1 / keypoint.response));
}

void copy_keypoint(const FeatureFrame& from, std::size_t k, FeatureFrame& to) {
  to.keypoints.push_back(from.keypoints[k]);
  const auto begin = from.descriptors.begin() + static_cast<std::ptrdiff_t>(k) * kDescriptorSize;
  to.descriptors.insert(to.descriptors.end(), begin, begin + kDescriptorSize);
}

// An image in which so many of a hundred features are where kNear sees them, each also half an
// image away, so that without a guess it is matched to neither; the others are where kFar does.
ObservedFrame seen_from_both(const SyntheticStream& world, int near_percent) {
  FeatureFrame frame = world.view(2, kFar);
  const FeatureFrame from_far = frame, from_near = world.view(2, kNear);
  frame.keypoints.clear();
  frame.descriptors.clear();
  const auto is_near = [&](const Keypoint& keypoint) {
    return 37 * point_of(keypoint) % 100 < near_percent;
  };
  for (std::size_t k = 0; k < from_far.keypoints.size(); ++k)
    if (!is_near(from_far.keypoints[k])) copy_keypoint(from_far, k, frame);
  for (std::size_t k = 0; k < from_near.keypoints.size(); ++k) {
    if (!is_near(from_near.keypoints[k])) continue;
    copy_keypoint(from_near, k, frame);
    copy_keypoint(from_near, k, frame);
    frame.keypoints.back().v = std::fmod(frame.keypoints.back().v + 240.0f, 480.0f);
  }
  return observe(frame, synthetic_camera(), MapSign::kMinus, MapperOptions().sigma_factor);
}

double distance(const Tracking& tracking, const Rigid3& pose) {
  return (tracking.world_from_camera.translation - pose.translation).norm();
}

TEST(OtherPlace, ALongStepIsTakenUnlessAsMuchAgreesNearby) {
  const SyntheticStream world;
  const Map map = one_place(world);
  ASSERT_GE(map.num_landmarks(), 80);
  const auto track = [&](int near_percent) {
    return track_frame(map, seen_from_both(world, near_percent), 1, {kLast}, MapperOptions());
  };
  for (const int near_percent : {0, 25}) {
    const Tracking tracking = track(near_percent);
    ASSERT_TRUE(tracking.ok()) << tracking.detail;
    EXPECT_LT(distance(tracking, kFar), 0.02);
    EXPECT_NE(tracking.source, PoseSource::kMapOnly);
  }
  EXPECT_EQ(track(45).reason, Reason::kAmbiguousPlace);
  const Tracking tracking = track(60);
  ASSERT_TRUE(tracking.ok()) << tracking.detail;
  EXPECT_LT(distance(tracking, kNear), 0.02);
  EXPECT_EQ(tracking.source, PoseSource::kMapOnly);  // the relative pose is that of the other place
}

// A sixth of the landmarks agree around the reference, which is what may agree by chance.
TEST(OtherPlace, WhereFewAgreeOtherKeyframesAreAsked) {
  const SyntheticStream world;
  Map map(synthetic_camera(), {});
  add_place(world, Rigid3(), 6, map);
  add_place(world, Rigid3(), 1, map);
  const ObservedFrame view = observed_view(world, 2, kNear);
  const auto track = [&](int neighbours) {
    return track_frame(map, view, 1, {kLast}, MapperOptions(), neighbours);
  };
  const Tracking alone = track(0), with_others = track(3);
  ASSERT_TRUE(alone.ok()) << alone.detail;
  ASSERT_LT(static_cast<int>(alone.sights.size()), MapperOptions().lost.min_inliers)
      << "else this shows nothing";
  ASSERT_TRUE(with_others.ok()) << with_others.detail;
  EXPECT_EQ(with_others.reference, 3);
  EXPECT_GT(with_others.sights.size(), 3 * alone.sights.size());
  EXPECT_LT(distance(with_others, kNear), 0.02);
}

TEST(OtherPlace, ACameraThatWasLostMustKnowWhichOfTwoCopiesItSees) {
  const SyntheticStream world;
  const ObservedFrame view = observed_view(world, 2, kNear);
  const Rigid3 copy({1, 0, 0, 0}, {0, 0, 100});
  for (const int nth : {1, 2}) {  // the copy has all of the landmarks, or half of them
    Map map = one_place(world);
    add_place(world, copy, nth, map);
    EXPECT_LT(distance(relocalize(map, view, {3}, MapperOptions()), copy * kNear), 0.02);
    const Tracking tracking = relocalize(map, view, {3, 1}, MapperOptions());
    EXPECT_EQ(tracking.reason, nth == 1 ? Reason::kAmbiguousPlace : Reason::kNone);
    if (nth != 1) {
      EXPECT_LT(distance(tracking, kNear), 0.02);
    }
  }
}

TEST(OtherPlace, TheNearOneNeedsAsMuchAndTheFarOneClearlyMore) {
  EXPECT_EQ(choose_place(100, 100), PlaceChoice::kNear);
  EXPECT_EQ(choose_place(100, 99), PlaceChoice::kNeither);
  EXPECT_EQ(choose_place(100, 70), PlaceChoice::kNeither);
  EXPECT_EQ(choose_place(100, 69), PlaceChoice::kFar);
}

}  // namespace
}  // namespace eifmap::test
