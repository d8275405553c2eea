#include "client/logger.h"

#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>

#include "bus/lcm_bus.h"
#include "client/map_points.h"
#include "convert/map_message.h"
#include "published/map_part.h"
#include "sequence/decisions_file.h"
#include "sequence/measurements_file.h"
#include "sequence/temporary_folder.h"
#include "sequence/tum.h"
#include "wire/channel.h"

namespace eifmap {
namespace {

class LoggerTest : public testing::Test {
 protected:
  LoggerTest() : lcm_(std::make_shared<lcm::LCM>("memq://")), bus_(lcm_), server_(lcm_) {
    open("");
  }

  void open(const std::string& camera) {
    logger_.reset();
    auto opened = Logger::open(folder_.path() / "log", camera, bus_);
    ASSERT_EQ(opened.problem, "");
    logger_ = std::move(opened.logger);
  }

  void send(const std::string& camera, ChannelKind kind, Bytes bytes) {
    server_.publish(channel_name(camera, kind), bytes);
    bus_.receive(std::chrono::milliseconds(50));
  }

  static PublishedPose pose(int i, TrackingState state, const std::string& camera = "cam") {
    PublishedPose pose;
    pose.origin = {5, camera};
    pose.result.time_us = 1000000 + 33333 * i;
    pose.result.seq = i;
    pose.result.map_id = 1;
    pose.result.state = state;
    pose.result.source = PoseSource::kScaleFit;
    pose.result.map_from_camera = {so3_exp({0.1 * i, 0.2, -0.3}), {i / 3.0, 0.1, -1e-9 * i}};
    return pose;
  }

  std::string text(const std::string& file) const {
    return read_text(folder_.path() / "log" / file);
  }

  TemporaryFolder folder_;
  std::shared_ptr<lcm::LCM> lcm_;
  LcmBus bus_, server_;
  std::unique_ptr<Logger> logger_;
};

TEST_F(LoggerTest, TrajectoryIsTheTextOfTheServersOwn) {
  std::vector<TimedPose> tracked;
  for (int i = 0; i < 20; ++i) {
    const auto state = i % 4 == 1 ? TrackingState::kLost : TrackingState::kTracking;
    const auto message = pose(i, state);
    send("cam", ChannelKind::kPose, encode(to_message(message)));
    if (state == TrackingState::kTracking)
      tracked.push_back({message.result.time_us, message.result.map_from_camera});
  }
  EXPECT_EQ(logger_->finish(), "");
  EXPECT_EQ(logger_->counts().poses, 20);
  EXPECT_EQ(logger_->counts().tracked, 15);
  ASSERT_EQ(write_tum(folder_.path() / "server.tum", tracked), "");
  EXPECT_EQ(text("trajectory.tum"), read_text(folder_.path() / "server.tum"));
  const std::string lines = text("poses.jsonl");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 20);  // lost ones too
  EXPECT_NE(lines.find("\"state\":\"LOST\""), std::string::npos);
}

// One map becomes metric on the way, another after its last pose, a third never.
TEST_F(LoggerTest, TheTrajectoryIsInMetresInTheEnd) {
  std::vector<TimedPose> expected;
  const auto add = [&](int i, std::int64_t map_id, ScaleStatus scale, double factor) {
    auto message = pose(i, TrackingState::kTracking);
    message.result.map_id = map_id;
    message.result.scale.status = scale;
    if (scale == ScaleStatus::kFixed) message.result.scale.metres_per_unit = 4;
    send("cam", ChannelKind::kPose, encode(to_message(message)));
    expected.push_back({message.result.time_us, message.result.map_from_camera});
    expected.back().world_from_camera.translation *= factor;
  };
  for (int i = 0; i < 3; ++i) add(i, 1, ScaleStatus::kFree, 4);
  for (int i = 3; i < 6; ++i) add(i, 1, ScaleStatus::kFixed, 1);
  for (int i = 6; i < 8; ++i) add(i, 2, ScaleStatus::kFree, 1);
  for (int i = 8; i < 10; ++i) add(i, 3, ScaleStatus::kFree, 0.5);
  status_t status{};
  status.camera = "cam";
  status.server_epoch = 5;
  status.map_id = 3;
  status.scale = status_t::SCALE_METRIC;
  status.metres_per_unit = 0.5;
  send("cam", ChannelKind::kStatus, encode(status));
  status.earth = status_t::EARTH_PLACED;
  status.earth_position[2] = 7.5;
  status.earth_quaternion[0] = 1;
  send("cam", ChannelKind::kStatus, encode(status));
  EXPECT_EQ(logger_->finish(), "");
  ASSERT_EQ(write_tum(folder_.path() / "expected.tum", expected), "");
  EXPECT_EQ(text("trajectory.tum"), read_text(folder_.path() / "expected.tum"));
  const std::string lines = text("status.jsonl");
  EXPECT_NE(lines.find("\"scale\":\"metric\",\"metres_per_unit\":0.5"), std::string::npos);
  EXPECT_NE(lines.find("\"earth\":\"unknown\""), std::string::npos);
  EXPECT_NE(lines.find("\"earth\":\"placed\",\"earth_from_map\":{\"position\":[0.0,0.0,7.5]"),
            std::string::npos);
}

TEST_F(LoggerTest, TheMapIsPutTogetherFromItsParts) {
  MapUpdate update;
  update.map_id = 1;
  update.seq = 1;
  update.base_seq = -1;
  const Rigid3 anchor(so3_exp({0, 0.5, 0}), {1, 2, 3});
  update.keyframes.push_back({4, 1000, anchor});
  for (int i = 0; i < 300; ++i) {
    LandmarkView landmark;
    landmark.id = i;
    landmark.anchor = 4;
    landmark.position_in_anchor = {0.25 * i, 1, 2};
    landmark.laplacian_sign = i % 2 == 0 ? 1 : -1;
    update.landmarks.push_back(landmark);
  }
  map_part_t whole = to_message(update, {5, "cam"}, 1000);
  PublishedMap published;
  published.apply(whole);
  whole.digest = published.digest();
  auto parts = split(whole, 4096);
  ASSERT_GT(parts.size(), 2u);
  std::reverse(parts.begin(), parts.end());
  for (const map_part_t& part : parts) send("cam", ChannelKind::kMap, encode(part));
  EXPECT_EQ(logger_->finish(), "");
  EXPECT_EQ(logger_->counts().map_parts, static_cast<std::int64_t>(parts.size()));
  const auto points = points_of(logger_->map().map());
  ASSERT_EQ(points.size(), 300u);
  EXPECT_LT((points[8].position - anchor * Eigen::Vector3d(2, 1, 2)).norm(), 1e-5);
  EXPECT_NE(text("map.ply").find("element vertex 300\n"), std::string::npos);
}

TEST_F(LoggerTest, DecisionsAreThereForAReplay) {
  std::vector<Decision> made;
  for (int i = 0; i < 20; ++i) {
    made.push_back({1000 + i, 9, i, i % 5, 77 * i});
    PublishedDecision decision;
    decision.decision = made.back();
    for (const char* camera : {"cam", "other"}) {
      decision.origin = {5, camera};
      send(camera, ChannelKind::kDecision, encode(to_message(decision)));
    }
    const auto read = read_decisions(folder_.path() / "log" / "decisions.jsonl");
    ASSERT_EQ(read.problem, "");
    ASSERT_EQ(read.decisions, made) << "each is there at once";
  }
  send("cam", ChannelKind::kDecision,
       encode(to_message(PublishedDecision{{6, "cam"}, {2000, 9, 20, 0, 0}})));
  const auto read = read_decisions(folder_.path() / "log" / "decisions.jsonl");
  EXPECT_NE(read.problem.find("decisions.jsonl line 21: another run of the server begins"),
            std::string::npos)
      << read.problem;
}

TEST_F(LoggerTest, MeasurementsAreThereForAReplay) {
  const auto measurement = [](std::int64_t seq, const std::string& camera = "cam") {
    AbsoluteMeasurement m;
    m.id = {9, seq};
    m.time_us = 1000 + seq;
    m.position = {1.0 / 3, 2, static_cast<double>(seq)};
    return NamedMeasurement{camera, m};
  };
  const auto send_one = [&](const NamedMeasurement& m) {
    send(m.camera, ChannelKind::kMeasurement, encode(to_message(m)));
  };
  send_one(measurement(0, "other"));
  send_one(measurement(1));
  EXPECT_EQ(text("measurements.jsonl"), "") << "nobody knows yet which camera is logged";
  send("cam", ChannelKind::kPose, encode(to_message(pose(0, TrackingState::kTracking))));
  for (const int seq : {2, 4, 2, 3, 1}) send_one(measurement(seq));
  send_one(measurement(9, "other"));
  std::string expected;
  for (const int seq : {1, 2, 4, 3}) expected += line_of(measurement(seq).measurement) + "\n";
  EXPECT_EQ(text("measurements.jsonl"), expected) << "each once, as it came";
  EXPECT_EQ(logger_->counts().measurements, 4);
}

TEST_F(LoggerTest, OneCameraOnly) {
  send("first", ChannelKind::kPose, encode(to_message(pose(0, TrackingState::kTracking, "first"))));
  send("other", ChannelKind::kPose, encode(to_message(pose(1, TrackingState::kTracking, "other"))));
  EXPECT_EQ(logger_->counts().poses, 1);
  open("other");
  send("first", ChannelKind::kPose, encode(to_message(pose(0, TrackingState::kTracking, "first"))));
  send("other", ChannelKind::kPose, encode(to_message(pose(1, TrackingState::kTracking, "other"))));
  EXPECT_EQ(logger_->counts().poses, 1);
  EXPECT_NE(text("poses.jsonl").find("\"camera\":\"other\""), std::string::npos);
}

TEST_F(LoggerTest, GarbageIsCountedAndPassedOver) {
  const std::vector<std::uint8_t> garbage(40, 0xee);
  for (const auto kind : {ChannelKind::kPose, ChannelKind::kMap, ChannelKind::kStatus,
                          ChannelKind::kDecision, ChannelKind::kMeasurement})
    send("cam", kind, garbage);
  auto bytes = encode(to_message(pose(1, TrackingState::kTracking)));
  bytes.resize(bytes.size() - 9);
  send("cam", ChannelKind::kPose, bytes);
  EXPECT_EQ(logger_->counts().malformed, 6);
  send("cam", ChannelKind::kPose, encode(to_message(pose(2, TrackingState::kTracking))));
  EXPECT_EQ(logger_->counts().tracked, 1);
}

TEST_F(LoggerTest, KnowsWhenTheServerStops) {
  status_t status{};
  status.metres_per_unit = 1;
  status.camera = "cam";
  status.state = status_t::STATE_TRACKING;
  status.message = "not UTF-8: \xff\xfe";
  send("cam", ChannelKind::kStatus, encode(status));
  EXPECT_FALSE(logger_->server_stopped());
  status.state = status_t::STATE_STOPPING;
  send("cam", ChannelKind::kStatus, encode(status));
  EXPECT_TRUE(logger_->server_stopped());
  EXPECT_EQ(logger_->counts().statuses, 2);
  const std::string lines = text("status.jsonl");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2);
}

status_t status_of(const std::string& camera, std::int64_t epoch, std::int8_t state) {
  status_t status{};
  status.metres_per_unit = 1;
  status.camera = camera;
  status.server_epoch = epoch;
  status.state = state;
  return status;
}

TEST_F(LoggerTest, OtherServersEndNothing) {
  send("cam", ChannelKind::kPose, encode(to_message(pose(0, TrackingState::kTracking))));
  const auto heard = logger_->last_message();
  send("other", ChannelKind::kStatus, encode(status_of("other", 6, status_t::STATE_STOPPING)));
  send("cam", ChannelKind::kStatus, encode(status_of("cam", 6, status_t::STATE_STOPPING)));
  send("server", ChannelKind::kStatus, encode(status_of("", 6, status_t::STATE_STOPPING)));
  EXPECT_EQ(logger_->counts().statuses, 0);
  EXPECT_FALSE(logger_->server_stopped());
  EXPECT_EQ(logger_->last_message(), heard) << "what is not taken does not break the silence";
  send("cam", ChannelKind::kStatus, encode(status_of("cam", 5, status_t::STATE_STOPPING)));
  EXPECT_TRUE(logger_->server_stopped());
}

TEST_F(LoggerTest, TakesWhatAServerSaysBeforeItHasACamera) {
  open("cam");
  send("server", ChannelKind::kStatus, encode(status_of("", 6, status_t::STATE_WAITING)));
  EXPECT_EQ(logger_->counts().statuses, 1);
  send("server", ChannelKind::kStatus, encode(status_of("", 6, status_t::STATE_STOPPING)));
  EXPECT_FALSE(logger_->server_stopped()) << "it may not be this camera's";
}

TEST_F(LoggerTest, SaysWhatIsWrongWithTheFolder) {
  folder_.write("file", "");
  EXPECT_NE(Logger::open(folder_.path() / "file" / "log", "", bus_).problem, "");
  EXPECT_NE(Logger::open(folder_.path(), "no such name", bus_).problem.find("'no such name'"),
            std::string::npos);
}

}  // namespace
}  // namespace eifmap
