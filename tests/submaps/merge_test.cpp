// A camera that walks from the room of one map into that of another.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "decision.h"
#include "map/keyframe_work.h"
#include "submaps/carried_camera.h"
#include "support/late_runner.h"

namespace eifmap::test {
namespace {

constexpr int kDark = 25;  // frames: longer than lost.new_map_after_s

// Map 1 is of A, map 2 of B.
void map_both(CarriedCamera& camera, double towards) {
  camera.look_around(Room::kA, towards - 0.8, towards + 0.4, 36);
  camera.covered(kDark);
  camera.look_around(Room::kB, towards - 0.8, towards + 0.4, 36);
}

// In A's map into B, of which the kept one is.
void go_to_b(CarriedCamera& camera) {
  map_both(camera, 0);
  camera.covered(kDark);
  camera.look_around(Room::kA, -0.1, 0, 6);
  camera.walk(0, 1, 140);
  camera.look_around(Room::kB, 0, 0.5, 15);
  camera.settle();
}

// In B's map into A, of which the kept one is.
void go_to_a(CarriedCamera& camera) {
  map_both(camera, M_PI);
  camera.look_around(Room::kB, M_PI + 0.4, M_PI, 12);
  camera.walk(1, 0, 140);
  camera.look_around(Room::kA, M_PI, M_PI + 0.5, 15);
  camera.settle();
}

void expect_one_map(const CarriedCamera& camera) {
  const MapperStatistics& s = camera.mapper().statistics();
  EXPECT_EQ(s.submaps.merged, 1) << s.submaps.last;
  EXPECT_EQ(s.submaps.kept, 0);
  EXPECT_EQ(s.starts, 2);
  EXPECT_EQ(camera.results().back().map_id, 1) << "the lower one is left";
  EXPECT_EQ(camera.results().back().state, TrackingState::kTracking);
  EXPECT_EQ(camera.poses_elsewhere(), 0);
  for (const std::string& problem : camera.problems()) ADD_FAILURE() << problem;
  const CarriedCamera::Errors errors = camera.errors();
  EXPECT_LT(errors.rmse, 0.1);
  EXPECT_LT(errors.largest, 0.3);
  // All but those in the dark, and a few before a map starts and until one is found.
  EXPECT_GT(errors.frames, static_cast<int>(s.tracked) - 5);
  ::testing::Test::RecordProperty("rmse_m", std::to_string(errors.rmse));
}

TEST(Merge, IntoTheMapInUse) {
  const RoomWorld world;
  CarriedCamera camera(world, MapperOptions());
  go_to_b(camera);
  expect_one_map(camera);
}

TEST(Merge, IntoTheKeptMap) {
  const RoomWorld world;
  CarriedCamera camera(world, MapperOptions());
  go_to_a(camera);
  expect_one_map(camera);
}

// Adopts each job when another run did.
class ReplayRunner : public KeyframeRunner {
 public:
  explicit ReplayRunner(const std::vector<FrameResult>& results) {
    for (const FrameResult& r : results) adopted_[r.seq] = decision_of(r).adopted_job;
  }
  void start(KeyframeJob job) override {
    job.run();
    job_.emplace(std::move(job));
  }
  bool due(const FeatureFrame& frame) override { return adopted_.at(frame.seq) == job_->id(); }
  KeyframeJob finish() override {
    KeyframeJob job = std::move(*job_);
    job_.reset();
    return job;
  }

 private:
  std::map<std::int64_t, std::int64_t> adopted_;  // by frame
  std::optional<KeyframeJob> job_;
};

TEST(Merge, BesideTheFramesAndAgainFromItsDecisions) {
  const RoomWorld world;
  LateRunner late(3);
  CarriedCamera live(world, MapperOptions(), &late);
  go_to_b(live);
  expect_one_map(live);
  EXPECT_GE(live.mapper().statistics().submaps.returned, 1);

  ReplayRunner replay(live.results());
  CarriedCamera again(world, MapperOptions(), &replay);
  go_to_b(again);
  ASSERT_EQ(again.results().size(), live.results().size());
  for (std::size_t i = 0; i < live.results().size(); ++i) {
    EXPECT_EQ(decision_of(again.results()[i]), decision_of(live.results()[i])) << i;
    EXPECT_EQ(again.results()[i].map_id, live.results()[i].map_id) << i;
    EXPECT_EQ(again.results()[i].map_epoch, live.results()[i].map_epoch) << i;
  }
  const auto first = live.mapper().final_trajectory(), second = again.mapper().final_trajectory();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k)
    EXPECT_EQ(first[k].world_from_camera.translation, second[k].world_from_camera.translation);
}

}  // namespace
}  // namespace eifmap::test
