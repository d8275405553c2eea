// A camera that is carried to another room, and back.
#include <gtest/gtest.h>

#include "submaps/carried_camera.h"

namespace eifmap::test {
namespace {

constexpr int kDark = 25;  // frames: longer than lost.new_map_after_s

void expect_sound(const CarriedCamera& camera) {
  for (const std::string& problem : camera.problems()) ADD_FAILURE() << problem;
  EXPECT_EQ(camera.poses_elsewhere(), 0);
}

// Map 1 is of A, map 2 of B.
void map_both(CarriedCamera& camera) {
  const FrameResult in_a = camera.look_around(Room::kA, -0.8, 0.4, 36);
  EXPECT_EQ(in_a.map_id, 1);
  EXPECT_EQ(in_a.map_epoch, 0);
  camera.covered(kDark);
  const FrameResult in_b = camera.look_around(Room::kB, -0.8, 0.4, 36);
  EXPECT_EQ(in_b.state, TrackingState::kTracking);
  EXPECT_EQ(in_b.map_id, 2);
  EXPECT_EQ(in_b.map_epoch, 1);
  EXPECT_EQ(camera.mapper().statistics().submaps.kept, 1);
}

TEST(Return, ToTheMapOfBefore) {
  const RoomWorld world;
  CarriedCamera camera(world, MapperOptions());
  map_both(camera);
  camera.covered(kDark);
  const std::int64_t keyframes = camera.mapper().statistics().keyframes;
  const FrameResult again = camera.look_around(Room::kA, -0.2, 0.2, 12);
  EXPECT_EQ(again.state, TrackingState::kTracking);
  EXPECT_EQ(again.map_id, 1);
  EXPECT_EQ(again.map_epoch, 2);
  camera.covered(kDark);
  const FrameResult in_b = camera.look_around(Room::kB, -0.2, 0.2, 12);
  EXPECT_EQ(in_b.map_id, 2);
  EXPECT_EQ(in_b.map_epoch, 3);
  EXPECT_GE(camera.mapper().statistics().keyframes, keyframes);
  const MapperStatistics& s = camera.mapper().statistics();
  EXPECT_EQ(s.starts, 2);
  EXPECT_EQ(s.submaps.returned, 2);
  EXPECT_EQ(s.submaps.merged, 0);
  expect_sound(camera);
}

// Soon after it was lost, too: no new map need be waited for.
TEST(Return, BeforeANewMapMayStart) {
  const RoomWorld world;
  CarriedCamera camera(world, MapperOptions());
  map_both(camera);
  camera.covered(3);
  const FrameResult again = camera.look_around(Room::kA, -0.1, 0.1, 8);
  EXPECT_EQ(again.map_id, 1);
  EXPECT_EQ(again.state, TrackingState::kTracking);
  expect_sound(camera);
}

TEST(Return, NotWhereNoMapIsKept) {
  const RoomWorld world;
  MapperOptions options;
  options.lost.max_kept_maps = 0;
  CarriedCamera camera(world, options);
  camera.look_around(Room::kA, -0.8, 0.4, 36);
  camera.covered(kDark);
  camera.look_around(Room::kB, -0.8, 0.4, 36);
  camera.covered(kDark);
  const FrameResult again = camera.look_around(Room::kA, -0.8, 0.4, 36);
  EXPECT_EQ(again.map_id, 3);
  EXPECT_EQ(again.map_epoch, 2);
  EXPECT_EQ(camera.mapper().statistics().submaps.kept, 0);
}

// Room B has a wall of A, of which half the view is full: that is no reason to be in A.
TEST(Return, NotToARoomThatIsAlikeInPart) {
  RoomWorldOptions alike;
  alike.alike = 0.3;
  const RoomWorld world(alike);
  CarriedCamera camera(world, MapperOptions());
  camera.look_around(Room::kA, -2.2, -0.9, 40);
  camera.covered(kDark);
  camera.look_around(Room::kB, -2.2, -0.9, 40);
  EXPECT_EQ(camera.mapper().statistics().submaps.returned, 0);
  EXPECT_EQ(camera.mapper().statistics().submaps.merged, 0);
  expect_sound(camera);
}

}  // namespace
}  // namespace eifmap::test
