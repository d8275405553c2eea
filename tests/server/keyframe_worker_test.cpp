// Jobs of a real mapper in a real thread.
#include "server/keyframe_worker.h"

#include <gtest/gtest.h>

#include <optional>

#include "map/keyframe_work.h"
#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

using When = Handover::When;

const SyntheticStream& world() {
  static const SyntheticStream stream;
  return stream;
}

FeatureFrame frame(int i) {
  return world().frame(i);
}

// A mapper's first, not yet run.
KeyframeJob job(std::int64_t id) {
  class Catcher : public KeyframeRunner {
   public:
    void start(KeyframeJob job) override { caught.emplace(std::move(job)); }
    bool due(const FeatureFrame&) override { return false; }
    KeyframeJob finish() override { return std::move(caught.value()); }
    std::optional<KeyframeJob> caught;
  } catcher;
  Mapper mapper(synthetic_camera(), {});
  mapper.set_keyframe_runner(&catcher, true);
  for (int i = 0; !catcher.caught; ++i) mapper.process(frame(i));
  catcher.caught->work().id = id;
  return catcher.finish();
}

// Throws when it is run: a feature that its frame does not have.
KeyframeJob throwing_job(std::int64_t id) {
  KeyframeJob bad = job(id);
  bad.work().tracking.sights.front().keypoint = 1'000'000;
  return bad;
}

// Of the map before, and with its own.
constexpr int kBefore = 2, kAfter = 3;

void wait_until_done(const KeyframeWorker& worker) {
  while (!worker.is_done()) std::this_thread::yield();
}

TEST(KeyframeWorker, WhenDoneIsDueOnceItIsDone) {
  KeyframeWorker worker({When::kWhenDone, 0, {}});
  for (std::int64_t id = 1; id <= 3; ++id) {
    EXPECT_FALSE(worker.has_job());
    EXPECT_FALSE(worker.may_be_adopted());
    worker.start(job(id));
    EXPECT_TRUE(worker.has_job());
    wait_until_done(worker);
    EXPECT_TRUE(worker.may_be_adopted());
    EXPECT_TRUE(worker.due(frame(0)));
    KeyframeJob done = worker.finish();
    EXPECT_EQ(done.id(), id);
    EXPECT_EQ(done.work().after->num_keyframes(), kAfter) << "it has run";
    EXPECT_EQ(done.work().before->num_keyframes(), kBefore);
  }
  EXPECT_FALSE(worker.is_done());
  EXPECT_GT(worker.take_busy_ms(), 0);
  EXPECT_EQ(worker.take_busy_ms(), 0);
}

TEST(KeyframeWorker, AfterFramesIsDueByCountAlone) {
  KeyframeWorker worker({When::kAfterFrames, 3, {}});
  for (int round = 0; round < 2; ++round) {
    worker.start(job(1));
    if (round == 1) wait_until_done(worker);
    EXPECT_FALSE(worker.due(frame(1)));
    EXPECT_FALSE(worker.due(frame(2)));
    EXPECT_FALSE(worker.may_be_adopted()) << "though it may be done, frames are counted";
    EXPECT_TRUE(worker.due(frame(3)));
    EXPECT_EQ(worker.finish().work().after->num_keyframes(), kAfter) << "waited for";
  }
}

TEST(KeyframeWorker, RecordedIsDueAsRecorded) {
  KeyframeWorker worker({When::kAsRecorded, 0, [](const FeatureFrame& f) { return f.seq == 2; }});
  worker.start(job(1));
  wait_until_done(worker);
  EXPECT_FALSE(worker.may_be_adopted());
  EXPECT_FALSE(worker.due(frame(1)));
  EXPECT_TRUE(worker.due(frame(2)));
  EXPECT_EQ(worker.finish().id(), 1);
}

TEST(KeyframeWorker, AnExceptionComesOutAndTheWorkerGoesOn) {
  KeyframeWorker worker({When::kWhenDone, 0, {}});
  for (int round = 0; round < 2; ++round) {
    worker.start(throwing_job(1));
    EXPECT_THROW(worker.finish(), std::out_of_range);
    EXPECT_FALSE(worker.has_job());
    worker.start(throwing_job(2));
    worker.discard();  // with what it threw
    worker.start(job(3));
    EXPECT_EQ(worker.finish().id(), 3);
  }
}

TEST(KeyframeWorker, DiscardWaitsAndForgets) {
  KeyframeWorker worker({When::kAfterFrames, 1, {}});
  worker.discard();  // nothing
  worker.start(job(1));
  worker.discard();
  EXPECT_FALSE(worker.has_job());
  EXPECT_THROW(worker.finish(), std::invalid_argument);
  worker.start(job(2));
  EXPECT_EQ(worker.finish().id(), 2);
}

TEST(KeyframeWorker, MisuseThrows) {
  EXPECT_THROW(KeyframeWorker({When::kAtOnce, 0, {}}), std::invalid_argument);
  KeyframeWorker worker({When::kWhenDone, 0, {}});
  EXPECT_THROW(worker.finish(), std::invalid_argument);
  worker.start(job(1));
  EXPECT_THROW(worker.start(job(2)), std::invalid_argument);
  EXPECT_EQ(worker.finish().id(), 1) << "as if nothing had been";
}

TEST(KeyframeWorker, EndsWhileAJobRuns) {
  for (int i = 0; i < 20; ++i) {
    KeyframeWorker worker({When::kWhenDone, 0, {}});
    worker.start(job(1));
    if (i % 2 == 1) wait_until_done(worker);
  }
  KeyframeWorker never_used({When::kWhenDone, 0, {}});
}

// A mapper whose frames come while its jobs run, and go before they are done.
TEST(KeyframeWorker, WithAMapper) {
  for (const When when : {When::kWhenDone, When::kAfterFrames}) {
    KeyframeWorker worker({when, 3, {}});
    {
      Mapper mapper(synthetic_camera(), {});
      mapper.set_keyframe_runner(&worker, true);
      int updates = 0;
      for (int i = 0; i < 60; ++i) {
        const FrameResult result = mapper.process(frame(i));
        EXPECT_NE(result.state, TrackingState::kLost);
        if (!result.map_updated) continue;
        EXPECT_EQ(mapper.map_update().seq, updates++);
      }
      EXPECT_GT(updates, 3);
    }
    worker.discard();
  }
}

}  // namespace
}  // namespace eifmap
