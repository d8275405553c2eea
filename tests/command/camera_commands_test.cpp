// What commands do to a camera's mapping, frame by frame and without a network.
#include "server/camera_commands.h"

#include <gtest/gtest.h>

#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/map_message.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

class CameraCommandsTest : public testing::Test {
 protected:
  static ServerConfig config() {
    ServerConfig config;
    config.input = InputMode::kLossless;
    return config;
  }
  void SetUp() override {
    const NamedCamera camera{1, "cam0", synthetic_camera()};
    ASSERT_EQ(mapper_.take_calibration("cam0", encode(to_message(camera))).reason, Reason::kNone);
  }
  FrameResult map(int i) {
    const FeatureFrame frame = stream_.frame(i);
    auto mapped = mapper_.take_frame({"cam0", ChannelKind::kFeatures}, encode(to_message(frame)));
    if (mapped.update)
      maps_.publish(to_message(*mapped.update, {42, "cam0"}, frame.time_us), "eifmap.cam0.map");
    return mapped.result;
  }
  void map(int from, int to) {
    for (int i = from; i < to; ++i) map(i);
  }
  static std::string value(const CommandOutcome& outcome, const std::string& wanted) {
    for (const auto& [key, value] : outcome.values)
      if (key == wanted) return value;
    return "";
  }

  const SyntheticStream stream_;
  CameraMapper mapper_{config()};
  MapPublisher maps_{{}};
  StatusBoard board_{42};
  std::vector<NamedMeasurement> sent_;
  CameraCommands commands_{42, mapper_, maps_, board_,
                           [this](ChannelKind kind, const std::vector<std::uint8_t>& bytes) {
                             EXPECT_EQ(kind, ChannelKind::kMeasurement);
                             sent_.push_back(decode_measurement(bytes).value);
                           }};
};

TEST_F(CameraCommandsTest, PauseAndResumeAreSaidInTheStatus) {
  const auto status = [this] { return board_.make("cam0", {}, {}, {}, {}, false); };
  EXPECT_EQ(commands_.resume().message, "it was not paused");
  EXPECT_EQ(commands_.pause().result, reply_t::RESULT_OK);
  EXPECT_EQ(commands_.pause().message, "it was paused already");
  EXPECT_EQ(status().state, status_t::STATE_PAUSED);
  EXPECT_EQ(status().reason, static_cast<int>(Reason::kPaused));
  EXPECT_EQ(value(commands_.ping(), "state"), "PAUSED");
  board_.note_paused_frame();
  EXPECT_NE(status().message.find("1 frames were left out"), std::string::npos);
  EXPECT_EQ(status().frames_rejected, 1);
  EXPECT_EQ(value(commands_.resume(), "frames_left_out"), "1");
  EXPECT_EQ(status().state, status_t::STATE_WAITING);
}

TEST_F(CameraCommandsTest, ResetBeginsAnotherMap) {
  EXPECT_NE(commands_.reset().message.find("nothing to give up"), std::string::npos);
  map(0, 20);
  const CommandTarget::Place before = commands_.place();
  ASSERT_EQ(before.map_id, 1);
  EXPECT_EQ(value(commands_.maps(), "map_id"), "1");
  const CommandOutcome outcome = commands_.reset();
  EXPECT_EQ(outcome.result, reply_t::RESULT_OK);
  EXPECT_EQ(value(outcome, "map_given_up"), "1");
  EXPECT_EQ(board_.headline().second, Reason::kMapReset);
  EXPECT_EQ(mapper_.statistics().frames, 0);
  EXPECT_TRUE(map(20).after_reset);
  EXPECT_FALSE(map(21).after_reset);
  map(22, 40);
  EXPECT_EQ(commands_.place().map_id, 2);
  EXPECT_GT(commands_.place().map_epoch, before.map_epoch);
  EXPECT_GT(commands_.place().map_seq, before.map_seq) << "updates are numbered through";
}

TEST_F(CameraCommandsTest, SnapshotSendsTheWholeMap) {
  EXPECT_EQ(commands_.snapshot().reason, Reason::kNoMap);
  map(0, 20);
  std::vector<map_part_t> parts;
  const auto send = [&](const std::string&, const std::vector<std::uint8_t>& bytes) {
    parts.push_back(decode_map_part(bytes).value);
  };
  const auto all_sent = std::chrono::steady_clock::now() + std::chrono::hours(1);
  for (auto at = all_sent; maps_.send_due(at, send); at += std::chrono::seconds(1)) {
  }
  parts.clear();
  const CommandOutcome outcome = commands_.snapshot();
  EXPECT_EQ(outcome.result, reply_t::RESULT_OK);
  for (auto at = all_sent + std::chrono::hours(1); maps_.send_due(at, send);
       at += std::chrono::seconds(1)) {
  }
  ASSERT_FALSE(parts.empty());
  EXPECT_EQ(value(outcome, "parts"), std::to_string(parts.size()));
  EXPECT_EQ(parts.front().base_seq, -1) << "all of it";
}

// The map's unit is said to be 2.5 m.
TEST_F(CameraCommandsTest, SetScaleMakesTheMapMetric) {
  EXPECT_EQ(commands_.set_scale(2.5, 0.001).reason, Reason::kNoMap);
  map(0, 40);
  EXPECT_EQ(commands_.set_scale(2.5, 0.09).reason, Reason::kBadArguments) << "never metric by that";
  const CommandOutcome outcome = commands_.set_scale(2.5, 0.001);
  ASSERT_EQ(outcome.result, reply_t::RESULT_ACCEPTED) << outcome.message;
  ASSERT_EQ(sent_.size(), 1u);
  const AbsoluteMeasurement& m = sent_[0].measurement;
  EXPECT_EQ(m.kind, MeasurementKind::kDistance);
  EXPECT_NEAR(m.sigma, 0.001 * m.length, 1e-12);
  // Heard again, as who sends by multicast hears himself.
  const auto heard = mapper_.take_measurement("cam0", encode(to_message(sent_[0])));
  EXPECT_EQ(heard.reason, Reason::kNone) << heard.detail;
  map(40, 80);
  EXPECT_EQ(mapper_.measurements().arrived, 1);
  const ScaleState scale = mapper_.statistics().scale;
  ASSERT_EQ(scale.status, ScaleStatus::kFixed);
  EXPECT_NEAR(scale.metres_per_unit, 2.5, 0.025);
  EXPECT_LT(scale.sigma, 0.05);
  EXPECT_EQ(commands_.set_scale(2.5, 0.001).reason, Reason::kMapIsMetric);
}

TEST_F(CameraCommandsTest, TheWholeServerIsShutDownAlone) {
  EXPECT_EQ(commands_.shutdown().reason, Reason::kUnsupported);
}

}  // namespace
}  // namespace eifmap
