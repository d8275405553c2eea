// A worker that is slowed at random: what it decides by timing differs from run to run, and a
// recorded run is made again to the bit however slow the worker is then.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <thread>

#include "decision.h"
#include "mapper.h"
#include "server/keyframe_worker.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

constexpr int kFrames = 90;

const std::vector<FeatureFrame>& frames() {
  static const std::vector<FeatureFrame> all = [] {
    const SyntheticStream world;
    std::vector<FeatureFrame> frames;
    for (int i = 0; i < kFrames; ++i) frames.push_back(world.frame(i, 0.08));
    return frames;
  }();
  return all;
}

void sleep_at_random(test::Random& random) {
  std::this_thread::sleep_for(std::chrono::microseconds(random.bits() % 8000));
}

class Bytes {
 public:
  void add(const Eigen::Ref<const Eigen::MatrixXd>& numbers) {
    for (const double x : numbers.reshaped()) add(x);
  }
  void add(const Rigid3& pose) {
    add(pose.translation);
    add(pose.rotation.coeffs());
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void add(T number) {
    char raw[sizeof number];
    std::memcpy(raw, &number, sizeof number);
    all_.append(raw, sizeof number);
  }
  const std::string& all() const { return all_; }

 private:
  std::string all_;
};

void add(Bytes& bytes, const KeyframeView& keyframe) {
  bytes.add(keyframe.id);
  bytes.add(keyframe.map_from_camera);
  bytes.add(keyframe.covariance);
}

void add(Bytes& bytes, const LandmarkView& landmark) {
  bytes.add(landmark.id);
  bytes.add(landmark.position_in_anchor);
  bytes.add(landmark.covariance);
}

void add(Bytes& bytes, const MapUpdate& update) {
  bytes.add(update.seq);
  for (const KeyframeView& k : update.keyframes) add(bytes, k);
  for (const LandmarkView& l : update.landmarks) add(bytes, l);
  for (const std::int64_t l : update.removed_landmarks) bytes.add(l);
}

// Everything that users get.
struct Record {
  std::vector<Decision> decisions;
  Bytes poses, updates, map;
};

// With `handover`'s worker; `between`: after each frame.
template <class Between>
Record run(const Handover& handover, const Between& between) {
  KeyframeWorker worker(handover);
  Mapper mapper(synthetic_camera(), {});
  mapper.set_keyframe_runner(&worker, true);
  Record run;
  for (const FeatureFrame& frame : frames()) {
    const FrameResult result = mapper.process(frame);
    EXPECT_NE(result.state, TrackingState::kLost);
    run.decisions.push_back(decision_of(result));
    run.poses.add(result.map_from_camera);
    run.poses.add(result.covariance);
    if (result.map_updated) add(run.updates, mapper.map_update());
    if (between(worker) && mapper.settle()) add(run.updates, mapper.map_update());
  }
  if (mapper.settle()) add(run.updates, mapper.map_update());
  for (const KeyframeView& k : mapper.keyframes()) add(run.map, k);
  for (const LandmarkView& l : mapper.landmarks()) add(run.map, l);
  for (const TimedPose& pose : mapper.final_trajectory()) run.map.add(pose.world_from_camera);
  return run;
}

// Decided by timing: each job is held for some frames more, drawn at random, and some time. The
// worker is niced, and a busy machine may starve it: every few frames, drawn at random too, it is
// waited for.
Record run_live(std::uint64_t seed) {
  test::Random in_worker(seed), in_tracking(seed + 1000);
  std::atomic<int> processed = 0;
  std::atomic<bool> waited_for = false;
  int waits_at = 4;
  bool before = true;
  Handover handover{Handover::When::kWhenDone, 0, {}, {}};
  handover.around_job = [&] {
    const int until = before ? processed + static_cast<int>(in_worker.bits() % 5) : 0;
    before = !before;
    while (processed < std::min(until, kFrames) && !waited_for) std::this_thread::yield();
    sleep_at_random(in_worker);
  };
  return run(handover, [&](const KeyframeWorker& worker) {
    sleep_at_random(in_tracking);
    if (++processed >= waits_at) {
      waited_for = true;
      while (worker.has_job() && !worker.is_done())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      waited_for = false;
      waits_at = processed + 4 + static_cast<int>(in_tracking.bits() % 5);
    }
    return worker.may_be_adopted() && in_tracking.uniform() < 0.3;
  });
}

Record run_again(const std::vector<Decision>& decisions, std::uint64_t seed) {
  test::Random in_worker(seed), in_tracking(seed + 1000);
  std::set<std::int64_t> adopting;
  for (const Decision& d : decisions)
    if (d.adopted_job != 0) adopting.insert(d.time_us);
  Handover handover{Handover::When::kAsRecorded, 0, {}, {}};
  handover.recorded = [&](const FeatureFrame& frame) { return adopting.contains(frame.time_us); };
  handover.around_job = [&] { sleep_at_random(in_worker); };
  return run(handover, [&](const KeyframeWorker&) {
    if (in_tracking.uniform() < 0.5) sleep_at_random(in_tracking);
    return false;
  });
}

std::vector<int> adopting_frames(const Record& run) {
  std::vector<int> frames;
  for (std::size_t i = 0; i < run.decisions.size(); ++i)
    if (run.decisions[i].adopted_job > 0) frames.push_back(static_cast<int>(i));
  return frames;
}

TEST(SlowedWorker, ARecordedRunIsMadeAgainToTheBitHoweverSlowTheWorkerIs) {
  std::set<std::vector<int>> ways;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Record live = run_live(seed);
    ways.insert(adopting_frames(live));
    EXPECT_GT(adopting_frames(live).size(), 5u) << "else this shows little";
    for (const std::uint64_t other : {11, 12}) {
      const Record again = run_again(live.decisions, other);
      ASSERT_EQ(again.decisions.size(), live.decisions.size());
      for (std::size_t i = 0; i < live.decisions.size(); ++i) {
        ASSERT_EQ(again.decisions[i].adopted_job, live.decisions[i].adopted_job) << i;
        ASSERT_EQ(again.decisions[i].state_digest, live.decisions[i].state_digest) << i;
      }
      EXPECT_TRUE(again.poses.all() == live.poses.all());
      EXPECT_TRUE(again.updates.all() == live.updates.all());
      EXPECT_TRUE(again.map.all() == live.map.all());
    }
  }
  EXPECT_GT(ways.size(), 1u) << "the slowness changed nothing: this shows nothing";
}

}  // namespace
}  // namespace eifmap
