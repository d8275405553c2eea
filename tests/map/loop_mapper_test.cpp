// A lap that is closed while the mapper goes on.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "geometry/similarity.h"
#include "map/measurement_desk.h"
#include "map/trajectory_log.h"
#include "mapper.h"
#include "simulation/feature_world.h"
#include "support/late_runner.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

// So much noise that the lap's ends are far from each other.
const FeatureWorld& world() {
  static const FeatureWorld world = [] {
    FeatureWorldOptions options;
    options.motion = "loop";
    options.num_frames = 288;
    options.noise_px = 2;
    options.sigma_px = 1;
    options.seed = 1;
    return FeatureWorld(options);
  }();
  return world;
}

const std::vector<FeatureFrame>& frames() {
  static const std::vector<FeatureFrame> frames = [] {
    std::vector<FeatureFrame> all;
    for (int i = 0; i < world().num_frames(); ++i) all.push_back(world().frame(i).frame);
    return all;
  }();
  return frames;
}

struct LapRun {
  MapperStatistics statistics;
  std::vector<TimedPose> trajectory;
  std::vector<std::string> problems;
  std::int64_t epoch = 0;
  int whole_updates = 0;  // that came with another epoch
  int lost = 0;
  double error = 0;  // m, RMSE after alignment
};

LapRun run(bool closes, KeyframeRunner* runner = nullptr) {
  MapperOptions options;
  options.loop.enabled = closes;
  Mapper mapper(world().camera(), options);
  if (runner) mapper.set_keyframe_runner(runner, true);
  LapRun run;
  for (const FeatureFrame& frame : frames()) {
    const FrameResult result = mapper.process(frame);
    run.lost += result.state == TrackingState::kLost;
    if (result.map_updated) {
      const MapUpdate update = mapper.map_update();
      run.whole_updates += update.map_epoch != run.epoch && update.base_seq == -1;
      EXPECT_TRUE(update.map_epoch == run.epoch || update.base_seq == -1);
      run.epoch = update.map_epoch;
    }
  }
  mapper.settle();
  mapper.set_keyframe_runner(nullptr, false);
  run.statistics = mapper.statistics();
  run.trajectory = mapper.final_trajectory();
  run.problems = mapper.audit();
  Eigen::Matrix3Xd truth(3, run.trajectory.size()), estimate(3, run.trajectory.size());
  for (std::size_t k = 0; k < run.trajectory.size(); ++k) {
    const TimedPose& pose = run.trajectory[k];
    const auto i = static_cast<int>((pose.time_us - frames()[0].time_us + 50'000) / 100'000);
    truth.col(static_cast<Eigen::Index>(k)) = world().world_from_camera(i).translation;
    estimate.col(static_cast<Eigen::Index>(k)) = pose.world_from_camera.translation;
  }
  const Similarity s = fit_similarity(truth, estimate);
  for (Eigen::Index k = 0; k < truth.cols(); ++k)
    run.error += (truth.col(k) - s * Eigen::Vector3d(estimate.col(k))).squaredNorm();
  run.error = std::sqrt(run.error / static_cast<double>(truth.cols()));
  return run;
}

void expect_closed(const LapRun& with, const LapRun& without) {
  EXPECT_GE(with.statistics.loops.closed, 1);
  EXPECT_GE(with.epoch, 1);
  EXPECT_GE(with.whole_updates, 1);
  EXPECT_EQ(with.lost, 0);
  EXPECT_LT(with.error, 0.6 * without.error);
  EXPECT_EQ(with.trajectory.size(), without.trajectory.size());
  for (const std::string& problem : with.problems) ADD_FAILURE() << problem;
}

TEST(LoopMapper, ClosesALapAndGoesOn) {
  const LapRun without = run(false), with = run(true);
  EXPECT_EQ(without.statistics.loops.closed + without.statistics.loops.joined, 0);
  EXPECT_EQ(without.epoch, 0);
  expect_closed(with, without);
}

TEST(LoopMapper, ClosesBesideTheFramesAndTheSameEachTime) {
  LateRunner first(3), second(3);
  const LapRun without = run(false), with = run(true, &first), again = run(true, &second);
  expect_closed(with, without);
  ASSERT_EQ(with.trajectory.size(), again.trajectory.size());
  for (std::size_t k = 0; k < with.trajectory.size(); ++k)
    EXPECT_EQ(with.trajectory[k].world_from_camera.translation,
              again.trajectory[k].world_from_camera.translation);
}

// What is placed relative to a keyframe grows with what is near it.
TEST(LoopMapper, FramesGrowWithTheirKeyframes) {
  const SyntheticStream stream;
  Map map = make_scene(stream, 2);
  TrajectoryLog log;
  log.add(10, 0, {so3_exp({0, 0, 0}), {1, 0, 0}});
  log.add(20, 1, {so3_exp({0, 0, 0}), {1, 0, 0}});
  log.grow({1, 1.5});
  EXPECT_EQ(log.in(map)[0].world_from_camera.translation.x(), 1);
  EXPECT_NEAR((map.pose(1).inverse() * log.in(map)[1].world_from_camera.translation).x(), 1.5,
              1e-12);
  PlacedFrame frame;
  frame.keyframe_from_camera.translation = {1, 2, 3};
  frame.turn_covariance.setOnes();
  frame.centre_covariance.setOnes();
  frame.grow(2);
  EXPECT_EQ(frame.keyframe_from_camera.translation, Eigen::Vector3d(2, 4, 6));
  EXPECT_EQ(frame.turn_covariance(0, 0), 1);
  EXPECT_EQ(frame.centre_covariance(2, 2), 4);
}

}  // namespace
}  // namespace eifmap::test
