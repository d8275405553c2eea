// Logs of live runs mapped again: to the bit, or it is said what is not as it was.
#include "server/log_run.h"

#include <gtest/gtest.h>

#include "convert/camera_message.h"
#include "convert/decision_message.h"
#include "convert/feature_parts.h"
#include "convert/measurement_message.h"
#include "convert/pose_message.h"
#include "sequence/temporary_folder.h"
#include "server/camera_mapper.h"
#include "server/let_keyframe_in.h"
#include "support/event_log_writer.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

constexpr int kFrames = 40;
constexpr std::int64_t kEpoch = 4711;

using Wire = std::vector<std::uint8_t>;

// One camera of a live server, and the log of what it hears and says.
class LiveCamera {
 public:
  LiveCamera(test::EventLogWriter& log, std::string name, std::int64_t epoch = kEpoch)
      : log_(log), name_(std::move(name)), epoch_(epoch) {}

  void calibrate(const Camera& camera = synthetic_camera()) {
    hear(ChannelKind::kCalibration, encode(to_message(NamedCamera{1, name_, camera})));
  }
  void measure(const AbsoluteMeasurement& measurement) {
    hear(ChannelKind::kMeasurement, encode(to_message(NamedMeasurement{name_, measurement})));
  }
  Wire wire(FeatureFrame frame) const {
    frame.camera = name_;
    return encode(to_message(frame));
  }

  void pass_over(const FeatureFrame& frame) { write(ChannelKind::kFeatures, wire(frame)); }
  FrameResult map(const FeatureFrame& frame) {
    hear(ChannelKind::kFeatures, wire(frame));
    return said_;
  }
  // The log has the frame in parts.
  void map_in_parts(FeatureFrame frame) {
    frame.camera = name_;
    for (const feature_frame_t& part : split_features(frame, 5000))
      write(ChannelKind::kFeatures, encode(part));
    take(ChannelKind::kFeatures, wire(frame));
  }
  // The logger has lost what is heard next.
  void lose_next() { lost_ = true; }

  void let_keyframe_in() { eifmap::let_keyframe_in(mapper_); }

  // Keyframes have time to go in after every fourth frame alone.
  void map_all(const SyntheticStream& stream, int from = 0, int to = kFrames) {
    for (int i = from; i < to; ++i) {
      if (i % 9 == 5) {
        pass_over(stream.frame(i));
        continue;
      }
      map(stream.frame(i));
      if (i % 4 == 0) let_keyframe_in();
    }
  }

  void write_results(const std::filesystem::path& folder) {
    mapper_.adopt_keyframe(true);
    ASSERT_GT(mapper_.statistics().keyframes, 3) << "else this shows little";
    ASSERT_EQ(mapper_.write_results(folder), "");
  }

  // Of the last decision, which is not written but given out.
  void forge_digest() { forged_ = true; }

 private:
  void write(ChannelKind kind, Bytes bytes) {
    if (!std::exchange(lost_, false)) log_.write(name_, kind, bytes);
  }
  void hear(ChannelKind kind, const Wire& bytes) {
    write(kind, bytes);
    take(kind, bytes);
  }
  void take(ChannelKind kind, const Wire& bytes) {
    if (kind == ChannelKind::kCalibration) mapper_.take_calibration(name_, bytes);
    if (kind == ChannelKind::kMeasurement) mapper_.take_measurement(name_, bytes);
    if (kind != ChannelKind::kFeatures) return;
    said_ = mapper_.take_frame({name_, kind}, bytes).result;
    if (said_.rejected) return;
    const Origin origin{epoch_, name_};
    log_.write(name_, ChannelKind::kPose, encode(to_message(PublishedPose{origin, said_})));
    Decision decision = decision_of(said_);
    if (std::exchange(forged_, false)) decision.state_digest ^= 1;
    log_.write(name_, ChannelKind::kDecision,
               encode(to_message(PublishedDecision{origin, decision})));
  }

  test::EventLogWriter& log_;
  std::string name_;
  std::int64_t epoch_;
  CameraMapper mapper_{ServerConfig{}};
  FrameResult said_;
  bool lost_ = false, forged_ = false;
};

class LogRunTest : public testing::Test {
 protected:
  std::string replay(bool verify = true, std::optional<std::int64_t> epoch = {}) {
    LogRunOptions options;
    options.log = file();
    options.output = again();
    options.verify = verify;
    options.epoch = epoch;
    options.config = config_;
    notes_.clear();
    const LogRunResult result = run_log(
        options, [](int, int) { return true; },
        [this](const std::string& note) { notes_ += note + "\n"; });
    summary_ = result.summary;
    return result.problem;
  }
  static bool has(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
  }

  void expect_same(const std::filesystem::path& more = "") const {
    for (const char* name : {"decisions.jsonl", "trajectory.tum", "trajectory_final.tum",
                             "keyframes.tum", "map.ply"}) {
      EXPECT_NE(read_text(live() / more / name), "") << name;
      EXPECT_EQ(read_text(live() / more / name), read_text(again() / more / name)) << name;
    }
  }
  // A run over all of the stream's frames, with `meanwhile` before one of them.
  void run_live(int at, const std::function<void(LiveCamera&)>& meanwhile) {
    LiveCamera camera(writer_, "cam0");
    camera.calibrate();
    camera.map_all(stream_, 0, at);
    meanwhile(camera);
    camera.map_all(stream_, at);
    camera.write_results(live());
  }

  std::filesystem::path file() const { return folder_.path() / "log"; }
  std::filesystem::path live() const { return folder_.path() / "live"; }
  std::filesystem::path again() const { return folder_.path() / "again"; }

  const TemporaryFolder folder_;
  const SyntheticStream stream_;
  test::EventLogWriter writer_{file()};
  ServerConfig config_;
  std::string notes_, summary_;
};

TEST_F(LogRunTest, IsTheSameToTheBit) {
  run_live(20, [](LiveCamera&) {});
  EXPECT_EQ(replay(), "");
  expect_same();
  EXPECT_EQ(summary_, "36 frames mapped, all with the digests that were recorded");
  EXPECT_EQ(notes_, "");
}

TEST_F(LogRunTest, WhatTheServerRefusedHasNoPart) {
  run_live(20, [this](LiveCamera& camera) {
    camera.map(stream_.frame(17));  // late
    camera.map(stream_.frame(19));  // twice
    FeatureFrame bad = stream_.frame(20);
    bad.keypoints[3].u = -40;
    camera.map(bad);
    writer_.write("eifmap.cam0.features", Wire(100, 0xa5));
    writer_.write("eifmap.cam0.decision.of.another", Wire(100, 0xa5));
    writer_.write("CAMERA", Wire(100, 0xa5));
  });
  EXPECT_EQ(replay(), "");
  expect_same();
}

TEST_F(LogRunTest, FramesInPartsAreMadeWhole) {
  run_live(20, [this](LiveCamera& camera) {
    for (int i = 0; i < 3; ++i) {
      FeatureFrame frame = stream_.frame(20);
      frame.time_us -= 90'000 - 20'000 * i;
      camera.map_in_parts(frame);
    }
  });
  EXPECT_EQ(replay(), "");
  expect_same();
}

TEST_F(LogRunTest, PartsThatTheLoggerLostAreSaid) {
  run_live(20, [this](LiveCamera& camera) {
    FeatureFrame frame = stream_.frame(20);
    frame.time_us -= 50'000;
    camera.lose_next();
    camera.map_in_parts(frame);
  });
  const std::string problem = replay();
  EXPECT_TRUE(has(problem, "of 1 frames of features 1 parts are not in the log")) << problem;
}

// The server believes times that lie back when there are enough of them; those that it refused
// before have no decisions.
TEST_F(LogRunTest, AClockThatWasSetBackIsFollowed) {
  LiveCamera camera(writer_, "cam0");
  camera.calibrate();
  camera.map_all(stream_);
  int refused = 0;
  for (int i = kFrames; i < kFrames + 60; ++i) {
    FeatureFrame frame = stream_.frame(i);
    frame.time_us -= 3'900'000;
    refused += camera.map(frame).rejected;
  }
  EXPECT_EQ(refused, Mapper::kPatience);
  camera.write_results(live());
  EXPECT_EQ(replay(), "");
  expect_same();
}

TEST_F(LogRunTest, AnotherCalibrationBeginsAnew) {
  LiveCamera camera(writer_, "cam0");
  camera.calibrate();
  for (int i = 0; i < 15; ++i) camera.map(stream_.frame(i));
  Camera other = synthetic_camera();
  other.fx *= 1.01;
  camera.calibrate(other);
  for (int i = 0; i < kFrames; ++i) {  // the clock and the numbers, too
    FeatureFrame frame = stream_.frame(i);
    frame.calibration_id = other.id();
    camera.map(frame);
    if (i % 4 == 0) camera.let_keyframe_in();
  }
  camera.write_results(live());
  EXPECT_EQ(replay(), "");
  expect_same();
}

TEST_F(LogRunTest, MeasurementsComeWhereTheyCame) {
  LiveCamera camera(writer_, "cam0");
  camera.calibrate();
  for (int i = 0; i < kFrames; ++i) {
    AbsoluteMeasurement m;
    m.id = {8, i};
    m.time_us = stream_.frame(i).time_us + 1000 * (i % 5);
    m.position = {0.1 * i, 0, 0};
    m.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    camera.measure(m);
    camera.map(stream_.frame(i));
    if (i % 4 == 0) camera.let_keyframe_in();
  }
  camera.write_results(live());
  EXPECT_NE(read_text(live() / "measurements.jsonl"), "");
  EXPECT_EQ(replay(), "");
  expect_same();
  EXPECT_EQ(read_text(live() / "measurements.jsonl"), read_text(again() / "measurements.jsonl"));
}

TEST_F(LogRunTest, AMeasurementThatIsMissingIsSaid) {
  run_live(20, [this](LiveCamera& camera) {
    AbsoluteMeasurement m;
    m.id = {8, 1};
    m.time_us = stream_.frame(19).time_us;
    camera.lose_next();
    camera.measure(m);
  });
  EXPECT_TRUE(
      has(replay(), "1 absolute measurements that had a part in the run are not in the log"))
      << replay();
}

TEST_F(LogRunTest, TheFirstOtherDigestIsNamed) {
  run_live(20, [](LiveCamera& camera) { camera.forge_digest(); });
  const std::string problem = replay();
  const std::string name = "the frame of " + std::to_string(stream_.frame(20).time_us) +
                           " us (publisher 7, seq 20) is the first that comes out otherwise";
  EXPECT_TRUE(has(problem, "camera cam0: " + name)) << problem;
  EXPECT_EQ(replay(false), "");
  EXPECT_TRUE(has(notes_, name)) << notes_;
  expect_same();
}

TEST_F(LogRunTest, OtherSettingsDepart) {
  run_live(20, [](LiveCamera&) {});
  config_.mapper = MapperOptions::paper();
  EXPECT_TRUE(has(replay(), "the settings")) << replay();
}

TEST_F(LogRunTest, AFrameThatTheLoggerLostIsNamed) {
  run_live(20, [](LiveCamera& camera) { camera.lose_next(); });
  EXPECT_TRUE(
      has(replay(), "1 of the 36 frames that were mapped are not in the log: the frame of " +
                        std::to_string(stream_.frame(20).time_us) + " us"))
      << replay();
}

TEST_F(LogRunTest, OfSeveralRunsTheLongestIsMadeAgain) {
  {
    LiveCamera short_one(writer_, "cam0", 99);
    short_one.calibrate();
    short_one.map_all(stream_, 0, 10);
  }
  run_live(20, [](LiveCamera&) {});
  EXPECT_EQ(replay(), "");
  EXPECT_TRUE(has(notes_, "decisions of 2 runs of the server: that of server_epoch 4711"))
      << notes_;
  expect_same();
  EXPECT_EQ(replay(true, 99), "");
  EXPECT_TRUE(has(summary_, "9 frames mapped")) << summary_;
  EXPECT_TRUE(has(replay(true, 100), "--epoch may be 99 4711")) << replay(true, 100);
}

TEST_F(LogRunTest, SeveralCamerasHaveFoldersOfTheirOwn) {
  LiveCamera left(writer_, "left"), right(writer_, "right"), idle(writer_, "idle");
  const SyntheticStream other(2);
  for (LiveCamera* camera : {&left, &right}) camera->calibrate();
  for (int i = 0; i < kFrames; ++i) {
    left.map(stream_.frame(i));
    right.map(other.frame(i));
    idle.pass_over(other.frame(i));
    if (i % 4 > 0) continue;
    left.let_keyframe_in();
    right.let_keyframe_in();
  }
  left.write_results(live() / "left");
  right.write_results(live() / "right");
  EXPECT_EQ(replay(), "");
  expect_same("left");
  expect_same("right");
  EXPECT_FALSE(std::filesystem::exists(again() / "idle"));

  config_.camera = "right";
  std::filesystem::remove_all(again());
  EXPECT_EQ(replay(), "");
  EXPECT_EQ(read_text(again() / "map.ply"), read_text(live() / "right" / "map.ply"));
  config_.camera = "front";
  EXPECT_TRUE(has(replay(), "nothing of camera front, but of left right")) << replay();
}

TEST_F(LogRunTest, WithoutDecisionsEveryFrameIsMapped) {
  writer_.write("cam0", ChannelKind::kCalibration,
                encode(to_message(NamedCamera{1, "cam0", synthetic_camera()})));
  CameraMapper mapper([] {
    ServerConfig config;
    config.input = InputMode::kLossless;
    return config;
  }());
  mapper.take_calibration("cam0", encode(to_message(NamedCamera{1, "cam0", synthetic_camera()})));
  for (int i = 0; i < kFrames; ++i) {
    const Wire bytes = encode(to_message(stream_.frame(i)));
    writer_.write("cam0", ChannelKind::kFeatures, bytes);
    mapper.take_frame({"cam0", ChannelKind::kFeatures}, bytes);
  }
  ASSERT_EQ(mapper.write_results(live()), "");
  EXPECT_EQ(replay(false), "");
  EXPECT_TRUE(has(notes_, "no decisions of a server: every frame of it is mapped")) << notes_;
  EXPECT_EQ(summary_, "40 frames mapped");
  expect_same();
  EXPECT_TRUE(has(replay(true), "leave out --verify"));
}

TEST_F(LogRunTest, ACutLogIsMappedUpToThere) {
  run_live(20, [](LiveCamera&) {});
  std::filesystem::resize_file(file(), std::filesystem::file_size(file()) * 9 / 10);
  EXPECT_TRUE(has(replay(), "is cut off at byte")) << replay();
  EXPECT_EQ(replay(false), "");
  EXPECT_TRUE(has(notes_, "is cut off at byte")) << notes_;
  EXPECT_GT(read_text(again() / "trajectory.tum").size(), 1000u);
}

TEST_F(LogRunTest, ALogWithoutFramesIsAProblem) {
  EXPECT_TRUE(has(replay(false), "has no frames")) << replay(false);
  writer_.write("cam0", ChannelKind::kFeatures, encode(to_message(stream_.frame(0))));
  EXPECT_TRUE(has(replay(false), "no frame of it could be mapped")) << replay(false);
  EXPECT_TRUE(has(notes_, "camera cam0: none of its frames is calibrated")) << notes_;
}

}  // namespace
}  // namespace eifmap
