// Keyframes that go into the map beside the frames: with runners of the test's own, which decide
// before which frame a job is adopted.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <random>
#include <set>
#include <sstream>

#include "decision.h"
#include "map/keyframe_work.h"
#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap::test {
namespace {

// Runs each job at once and holds it back.
class OwnRunner : public KeyframeRunner {
 public:
  // Before the n-th frame after a job's own, or, n = 0, never.
  explicit OwnRunner(int n) : due_([n](const FeatureFrame&, int since) { return since == n; }) {}
  using Due = std::function<bool(const FeatureFrame&, int since)>;
  explicit OwnRunner(Due due) : due_(std::move(due)) {}

  void start(KeyframeJob job) override {
    EXPECT_FALSE(job_) << "another is not finished";
    if (!late) run(job);
    job_.emplace(std::move(job));
    seqs.push_back(job_->work().observed->frame.seq);
    ++started;
    since_ = 0;
  }
  bool due(const FeatureFrame& frame) override {
    EXPECT_TRUE(job_) << "asked only while there is one";
    return due_(frame, ++since_);
  }
  KeyframeJob finish() override {
    if (throws) {
      job_.reset();
      throw std::invalid_argument("two of a kind");
    }
    KeyframeJob job = std::move(job_.value());
    job_.reset();
    if (late) run(job);
    return job;
  }
  bool has_job() const { return job_.has_value(); }

  int started = 0;
  std::vector<std::int64_t> seqs;  // of the jobs' frames
  bool throws = false;
  bool late = false;             // run the job when it is finished
  std::set<std::int64_t> fails;  // jobs whose map turns out not to be trusted

 private:
  void run(KeyframeJob& job) const {
    KeyframeWork& work = job.work();
    const std::optional<MapNews> news = work.news;
    job.run();
    if (!fails.contains(job.id())) return;
    work.insertion.reason = Reason::kScaleJump;
    work.news = news;  // it ends there
    work.update.reset();
  }

  Due due_;
  std::optional<KeyframeJob> job_;
  int since_ = 0;
};

Rigid3 sideways(int i) {
  return {so3_exp({0, 0.002 * i, 0}), {0.1 * i, 0.01 * i, 0.02 * i}};
}

FeatureFrame dark(FeatureFrame frame) {
  frame.keypoints.clear();
  frame.descriptors.clear();
  return frame;
}

// Every bit as text.
class Bits {
 public:
  Bits() { out_ << std::hexfloat; }
  Bits& operator<<(const Rigid3& pose) {
    out_ << pose.rotation.coeffs().transpose() << ' ' << pose.translation.transpose() << '\n';
    return *this;
  }
  template <class T>
  Bits& operator<<(const T& value) {
    out_ << value << ' ';
    return *this;
  }
  std::string text() const { return out_.str(); }

 private:
  std::ostringstream out_;
};

std::string bits(const MapUpdate& update) {
  Bits out;
  out << update.map_id << update.base_seq << update.seq;
  for (const KeyframeView& k : update.keyframes)
    out << k.id << k.time_us << k.map_from_camera << k.covariance;
  for (const LandmarkView& l : update.landmarks)
    out << l.id << l.anchor << l.position_in_anchor.transpose() << l.num_observations
        << l.covariance;
  for (const std::int64_t id : update.removed_landmarks) out << id;
  for (const ObservationView& o : update.observations)
    out << o.keyframe << o.landmark << o.u << o.v;
  return out.text();
}

std::string map_bits(const Mapper& mapper) {
  Bits out;
  for (const TimedPose& k : mapper.keyframe_trajectory()) out << k.time_us << k.world_from_camera;
  for (const MapPoint& p : mapper.map_points())
    out << p.position.transpose() << p.laplacian_sign << p.num_observations;
  return out.text();
}

std::string bits(const FrameResult& r) {
  Bits out;
  out << r.time_us << r.map_id << static_cast<int>(r.state) << static_cast<int>(r.source)
      << static_cast<int>(r.reason) << r.detail << r.map_from_camera << r.covariance
      << r.reference_keyframe << r.reference_from_camera << r.num_matches << r.num_inliers;
  return out.text();
}

struct Outcome {
  std::string results, updates, map, trajectory;
  std::vector<Decision> decisions;
  std::vector<std::pair<std::int64_t, std::int64_t>> seqs;  // base_seq, seq of each update
  int lost = 0, adopted = 0;
  MapperStatistics statistics;
};

void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.results, b.results);
  EXPECT_EQ(a.updates, b.updates);
  EXPECT_EQ(a.map, b.map);
  EXPECT_EQ(a.trajectory, b.trajectory);
  EXPECT_EQ(a.decisions, b.decisions);
  EXPECT_EQ(a.statistics.losses, b.statistics.losses);
}

using Frames = std::vector<FeatureFrame>;

// `idle`: settles after the frame as a server does that has nothing else to do.
Outcome run(const Frames& frames, OwnRunner* runner, const std::function<bool(int)>& idle = {}) {
  Mapper mapper(synthetic_camera(), {});
  if (runner) mapper.set_keyframe_runner(runner, true);
  Outcome outcome;
  const auto take_update = [&] {
    const MapUpdate update = mapper.map_update();
    outcome.updates += bits(update);
    outcome.seqs.push_back({update.base_seq, update.seq});
  };
  int i = 0;
  for (const FeatureFrame& frame : frames) {
    const FrameResult result = mapper.process(frame);
    outcome.results += bits(result);
    outcome.decisions.push_back(decision_of(result));
    outcome.lost += result.state == TrackingState::kLost;
    outcome.adopted += result.adopted_job > 0;
    if (result.map_updated) take_update();
    if (idle && idle(i++) && mapper.settle()) take_update();
  }
  if (mapper.settle()) take_update();
  EXPECT_TRUE(mapper.audit().empty());
  outcome.map = map_bits(mapper);
  Bits trajectory;
  for (const TimedPose& p : mapper.final_trajectory())
    trajectory << p.time_us << p.world_from_camera;
  outcome.trajectory = trajectory.text();
  outcome.statistics = mapper.statistics();
  return outcome;
}

Frames walk(int count, double wrong_share = 0.1) {
  const SyntheticStream world;
  Frames frames;
  for (int i = 0; i < count; ++i) frames.push_back(world.view(i, sideways(i), wrong_share));
  return frames;
}

// A walk with all that may happen: the dark, for a frame and for long, and another publisher.
Frames adventure() {
  const SyntheticStream world;
  Frames frames = walk(75);
  for (const int i : {20, 33, 34, 47}) frames[i] = dark(frames[i]);
  for (int i = 55; i < 75; ++i) {
    frames[i] = world.view(i, sideways(i - 10));
    frames[i].publisher = 8;
  }
  return frames;
}

// Decides as another run did.
OwnRunner replaying(const std::vector<Decision>& decisions) {
  return OwnRunner([decisions](const FeatureFrame& frame, int) {
    for (const Decision& d : decisions)
      if (d.time_us == frame.time_us) return d.adopted_job != 0;
    return false;
  });
}

std::function<bool(int)> at_random(unsigned seed) {
  return [random = std::make_shared<std::mt19937>(seed)](int) { return (*random)() % 3 == 0; };
}

TEST(Handover, BeforeTheNextFrameIsAsIfAtOnce) {
  const Frames frames = walk(60);
  OwnRunner next(1);
  const Outcome beside = run(frames, &next), at_once = run(frames, nullptr);
  EXPECT_GT(next.started, 5);
  EXPECT_EQ(beside.map, at_once.map);
  EXPECT_EQ(beside.trajectory, at_once.trajectory);
  EXPECT_EQ(beside.updates, at_once.updates);
}

TEST(Handover, LaterItIsAnotherMapButOneThatHolds) {
  const Frames frames = walk(60);
  OwnRunner later(4);
  const Outcome run_later = run(frames, &later);
  EXPECT_NE(run_later.map, run(frames, nullptr).map) << "else the tests below show nothing";
  EXPECT_EQ(run_later.lost, 0);
  EXPECT_EQ(run_later.statistics.starts, 1);
}

TEST(Handover, UpdatesAreTheJobsAndChain) {
  OwnRunner later(3);
  const Outcome beside = run(walk(60), &later);
  ASSERT_EQ(static_cast<int>(beside.seqs.size()), 1 + later.started) << "the start's, each job's";
  for (std::size_t i = 0; i < beside.seqs.size(); ++i) {
    EXPECT_EQ(beside.seqs[i].first, static_cast<std::int64_t>(i) - 1);
    EXPECT_EQ(beside.seqs[i].second, static_cast<std::int64_t>(i));
  }
}

// Whenever it was that the jobs were adopted, between frames or before them or because tracking
// failed: their decisions make the same run again.
TEST(Handover, TheSameDecisionsGiveTheSameBytes) {
  const Frames frames = adventure();
  std::set<std::string> maps;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    OwnRunner random([due = at_random(seed)](const FeatureFrame&, int) { return due(0); });
    random.fails = {3, 6};
    const Outcome live = run(frames, &random, at_random(seed + 100));
    EXPECT_GE(live.adopted, 6) << "else this shows little";
    EXPECT_GE(live.statistics.losses, 3);
    OwnRunner again = replaying(live.decisions);
    again.fails = random.fails;
    const Outcome replayed = run(frames, &again);
    expect_same(live, replayed);
    maps.insert(live.map);
  }
  EXPECT_GT(maps.size(), 1u) << "other decisions, another map";
}

// Tracking fails, the keyframe in work is waited for, and its map is not to be trusted: the frame
// goes the way of one before which that was known, and is found again among the old keyframes.
TEST(Handover, AJobThatFailsWhereTrackingDoesIsAsOneThatFailedBefore) {
  const SyntheticStream world;
  const auto along = [&world](int i, double x) {
    return world.view(i, Rigid3({1, 0, 0, 0}, {x, 0, 0}));
  };
  Frames frames;
  for (int i = 0; i < 55; ++i) frames.push_back(along(i, -6 + 0.4 * i));
  OwnRunner probe(2);
  run(frames, &probe);
  const auto bad = static_cast<std::size_t>(probe.started);
  const auto jump = static_cast<int>(probe.seqs.back()) + 1;
  ASSERT_GT(jump, 48) << "the start is to be out of view";
  frames.resize(static_cast<std::size_t>(jump));
  for (int i = jump; i < jump + 10; ++i) frames.push_back(along(i, -6 + 0.1 * (i - jump)));

  OwnRunner waits([&](const FeatureFrame&, int since) {
    return since == 2 && static_cast<std::size_t>(waits.started) < bad;
  });
  waits.fails = {static_cast<std::int64_t>(bad)};
  const Outcome live = run(frames, &waits);
  const Decision& at_jump = live.decisions[static_cast<std::size_t>(jump)];
  EXPECT_EQ(at_jump.adopted_job, static_cast<std::int64_t>(bad)) << "waited for, though not due";
  EXPECT_EQ(live.statistics.losses, 1);
  EXPECT_EQ(live.statistics.sources.at(PoseSource::kRelocalized), 1);
  EXPECT_EQ(live.lost, 0) << "found again with the same frame";
  OwnRunner again = replaying(live.decisions);
  again.fails = waits.fails;
  expect_same(live, run(frames, &again));
}

TEST(Handover, BetweenFramesOrBeforeTheNextIsTheSame) {
  const Frames frames = adventure();
  OwnRunner next(1), never(0);
  next.fails = never.fails = {2, 5};
  const Outcome before_next = run(frames, &next);
  const Outcome idle = run(frames, &never, [](int) { return true; });
  EXPECT_GT(never.started, 5);
  expect_same(before_next, idle);
}

TEST(Handover, AFailedInsertionLeavesTheMapAsItWas) {
  const Frames frames = walk(40);
  Mapper mapper(synthetic_camera(), {});
  OwnRunner runner(0);
  mapper.set_keyframe_runner(&runner, true);
  std::size_t i = 0;
  const auto until_a_job_runs = [&] {
    while (!runner.has_job()) mapper.process(frames[i++]);
  };
  until_a_job_runs();
  ASSERT_TRUE(mapper.settle());
  const std::int64_t seq = mapper.map_update().seq;
  runner.fails = {2};
  until_a_job_runs();
  const std::string before = map_bits(mapper);
  EXPECT_FALSE(mapper.settle());
  EXPECT_EQ(map_bits(mapper), before);
  EXPECT_EQ(mapper.statistics().losses, 1);
  EXPECT_EQ(mapper.statistics().reasons.at(Reason::kScaleJump), 1);
  EXPECT_EQ(mapper.keyframes().size(), 3u) << "two of the start, one of the first job";

  const FrameResult back = mapper.process(frames[i++]);
  EXPECT_EQ(back.source, PoseSource::kRelocalized);
  EXPECT_EQ(back.adopted_job, 2) << "a replay must drop it at the same place";
  until_a_job_runs();
  ASSERT_TRUE(mapper.settle());
  const MapUpdate update = mapper.map_update();
  EXPECT_EQ(update.base_seq, seq) << "nothing of the map that was dropped was published";
  EXPECT_EQ(update.keyframes.back().id, 3) << "what was published before is known still";
  EXPECT_GT(update.observations.size(), 0u);
  std::set<std::int64_t> is_new;
  for (const LandmarkView& l : update.landmarks) is_new.insert(l.id);
  for (const ObservationView& o : update.observations)
    EXPECT_TRUE(o.keyframe == 3 || is_new.contains(o.landmark)) << o.keyframe;
  EXPECT_TRUE(mapper.audit().empty());
}

TEST(Handover, WhereTrackingFailsTheJobIsWaitedFor) {
  const SyntheticStream world;
  Mapper mapper(synthetic_camera(), {});
  OwnRunner runner(0);
  mapper.set_keyframe_runner(&runner, false);
  FrameResult result;
  // The camera leaves the view of the start, which is all that the map knows until then.
  for (int i = 0; i < 45 && result.adopted_job == 0; ++i) {
    result = mapper.process(world.view(i, Rigid3({1, 0, 0, 0}, {-6 + 0.4 * i, 0, 0})));
    ASSERT_NE(result.state, TrackingState::kLost) << i;
  }
  EXPECT_EQ(result.adopted_job, 1) << "nothing was due";
  EXPECT_EQ(result.state, TrackingState::kTracking);
  EXPECT_TRUE(result.map_updated);
}

TEST(Handover, AJobOfAMapThatWasGivenUpIsIgnored) {
  const SyntheticStream here(1), elsewhere(99);
  Mapper mapper(synthetic_camera(), {});
  bool due = false;
  OwnRunner runner([&due](const FeatureFrame&, int) { return due; });
  mapper.set_keyframe_runner(&runner, true);
  int i = 0;
  while (!runner.has_job()) mapper.process(here.view(i, sideways(i))), ++i;
  const auto view = [&] {
    FeatureFrame frame = elsewhere.view(i, sideways(i));
    frame.publisher = 8;  // its stream ends the other one: the job need not be waited for
    ++i;
    return frame;
  };
  FrameResult result;
  while (result.map_id < 2 && i < 100) result = mapper.process(view());
  ASSERT_EQ(result.map_id, 2);
  EXPECT_TRUE(result.map_updated);
  EXPECT_EQ(mapper.map_update().base_seq, -1);
  EXPECT_EQ(runner.started, 1);
  EXPECT_TRUE(runner.has_job());
  const std::string before = map_bits(mapper);
  due = true;
  result = mapper.process(view());
  due = false;
  EXPECT_EQ(result.adopted_job, 1) << "a replay must finish it at the same place";
  EXPECT_FALSE(result.map_updated);
  EXPECT_EQ(result.state, TrackingState::kTracking);
  EXPECT_EQ(map_bits(mapper), before);
  while (runner.started < 2 && i < 120) mapper.process(view());
  EXPECT_TRUE(mapper.settle()) << "the new map's own";
  EXPECT_EQ(mapper.map_update().base_seq, 0);
}

TEST(Handover, ARefusedFrameDoesNotTakeTheDecisionAlong) {
  const Frames frames = walk(40);
  Mapper mapper(synthetic_camera(), {});
  OwnRunner runner(0);
  mapper.set_keyframe_runner(&runner, true);
  std::size_t i = 0;
  while (!runner.has_job()) mapper.process(frames[i++]);
  mapper.settle();
  const FrameResult refused = mapper.process(frames[i - 1]);
  ASSERT_TRUE(refused.rejected);
  EXPECT_EQ(refused.adopted_job, 0);
  EXPECT_EQ(mapper.process(frames[i]).adopted_job, 1);
}

// A fault after the adoption, which costs the frame: its successor says that the map has changed.
TEST(Handover, AFaultDoesNotTakeTheUpdateAlong) {
  const Frames frames = walk(40);
  Mapper mapper(synthetic_camera(), {});
  OwnRunner runner(1);
  mapper.set_keyframe_runner(&runner, true);
  std::size_t i = 0;
  while (!runner.has_job())
    if (mapper.process(frames[i++]).map_updated) mapper.map_update();
  mapper.set_step_observer([](std::string_view step, bool begins) {
    if (step == "observe" && begins) throw std::invalid_argument("two of a kind");
  });
  EXPECT_THROW(mapper.process(frames[i]), std::invalid_argument);
  mapper.set_step_observer({});
  const FrameResult next = mapper.process(frames[i + 1]);
  EXPECT_TRUE(next.map_updated);
  EXPECT_EQ(next.adopted_job, 1);
  EXPECT_EQ(mapper.map_update().base_seq, 0);
}

// It had part of the mapper's books, so this is no fault that costs one frame alone.
TEST(Handover, WhatAJobThrowsComesOut) {
  const Frames frames = walk(40);
  for (const bool idle : {false, true}) {
    Mapper mapper(synthetic_camera(), {});
    OwnRunner runner(1);
    runner.throws = true;
    mapper.set_keyframe_runner(&runner, true);
    std::size_t i = 0;
    while (!runner.has_job()) mapper.process(frames[i++]);
    const auto adopt = [&] { idle ? void(mapper.settle()) : void(mapper.process(frames[i])); };
    EXPECT_THROW(adopt(), std::runtime_error);
    EXPECT_FALSE(mapper.settle()) << "it is gone";
    EXPECT_GT(mapper.final_trajectory().size(), 0u) << "results can still be read";
  }
}

TEST(Handover, ARunnerWithAJobIsNotTakenAway) {
  const Frames frames = walk(40);
  Mapper mapper(synthetic_camera(), {});
  OwnRunner runner(0), other(0);
  mapper.set_keyframe_runner(&runner, false);
  mapper.set_keyframe_runner(&other, false);
  mapper.set_keyframe_runner(&runner, true);
  for (std::size_t i = 0; !runner.has_job(); ++i) mapper.process(frames[i]);
  EXPECT_THROW(mapper.set_keyframe_runner(&other, true), std::invalid_argument);
  EXPECT_THROW(mapper.set_keyframe_runner(nullptr, false), std::invalid_argument);
  mapper.settle();
  mapper.set_keyframe_runner(nullptr, false);
  const FrameResult result = mapper.process(frames.back());
  EXPECT_FALSE(runner.has_job());
  EXPECT_EQ(result.rejected, false);
}

// The job shares nothing that goes with the mapper.
TEST(Handover, AJobOutlivesItsMapper) {
  const Frames frames = walk(40);
  OwnRunner runner(0);
  runner.late = true;
  {
    Mapper mapper(synthetic_camera(), {});
    mapper.set_keyframe_runner(&runner, true);
    for (std::size_t i = 0; !runner.has_job(); ++i) mapper.process(frames[i]);
  }
  KeyframeJob job = runner.finish();
  EXPECT_EQ(job.work().insertion.reason, Reason::kNone);
  EXPECT_EQ(job.work().after->num_keyframes(), 3);
}

TEST(Handover, AskedAgainThereIsNoNews) {
  const Frames frames = walk(20);
  Mapper mapper(synthetic_camera(), {});
  std::size_t i = 0;
  while (!mapper.process(frames[i++]).map_updated) continue;
  EXPECT_GT(mapper.map_update().landmarks.size(), 0u);
  const MapUpdate again = mapper.map_update();
  EXPECT_EQ(again.base_seq, 0);
  EXPECT_TRUE(again.keyframes.empty() && again.landmarks.empty());
}

TEST(Handover, TheDigestTellsPosesApartAndNotTheServersCount) {
  FrameResult result;
  result.time_us = 5;
  const std::int64_t digest = decision_of(result).state_digest;
  FrameResult other = result;
  other.map_id = 7;
  EXPECT_EQ(decision_of(other).state_digest, digest);
  other.map_from_camera.translation.x() = std::numeric_limits<double>::denorm_min();
  EXPECT_NE(decision_of(other).state_digest, digest);
  other = result;
  other.state = TrackingState::kLost;
  EXPECT_NE(decision_of(other).state_digest, digest);
}

}  // namespace
}  // namespace eifmap::test
