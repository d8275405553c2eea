// The whole server under command, on an in-process network.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "client/command_caller.h"
#include "server/server_network.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

class MappingServerCommand : public testing::Test {
 protected:
  void open(const ServerConfig& config) {
    network_.emplace(config);
    network_->on_reply = [this](Bytes bytes) {
      const std::lock_guard lock(mutex_);
      replies_.emplace_back(bytes.begin(), bytes.end());
    };
  }
  void calibrate(const std::string& camera) { network_->publish(synthetic_camera(), camera); }
  void publish(const std::string& camera, int from, int to) {
    for (int i = from; i < to; ++i) {
      FeatureFrame frame = stream_.frame(i);
      frame.camera = camera;
      network_->publish(frame);
    }
    network_->settle();
  }
  reply_t command(const std::string& camera, std::int16_t code) {
    const auto now = [] { return std::chrono::steady_clock::now(); };
    CommandCaller caller({camera, code, {}}, nullptr, 30s, now());
    while (!caller.is_over()) {
      caller.tick(now(), [&](const std::string& channel, const auto& bytes) {
        network_->publish(*parse_channel(channel), bytes);
      });
      std::this_thread::sleep_for(1ms);
      const std::lock_guard lock(mutex_);
      for (; !replies_.empty(); replies_.pop_front()) caller.take(replies_.front(), now());
    }
    EXPECT_EQ(caller.state(), CommandCaller::State::kAnswered);
    return caller.state() == CommandCaller::State::kAnswered ? caller.reply() : reply_t{};
  }
  // Poses are heard when they come.
  void expect_poses(const std::string& camera, int count, const char* what = "") {
    const std::atomic<int>& heard = network_->of(camera).pose_count;
    for (int i = 0; i < 30000 && heard < count; ++i) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(heard, count) << camera << ' ' << what;
  }

  const SyntheticStream stream_;
  std::mutex mutex_;
  std::deque<std::vector<std::uint8_t>> replies_;
  std::optional<Network> network_;
};

TEST_F(MappingServerCommand, PausesGoesOnAndBeginsAgain) {
  open(lossless());
  calibrate("cam0");
  publish("cam0", 0, 20);
  expect_poses("cam0", 20);
  EXPECT_EQ(command("cam0", command_t::CMD_PAUSE).result, reply_t::RESULT_OK);
  publish("cam0", 20, 30);
  expect_poses("cam0", 20, "mapped although it was paused");
  EXPECT_EQ(command("cam0", command_t::CMD_RESUME).result, reply_t::RESULT_OK);
  publish("cam0", 30, 40);
  expect_poses("cam0", 30);
  const reply_t reset = command("cam0", command_t::CMD_RESET);
  EXPECT_EQ(reset.result, reply_t::RESULT_OK);
  publish("cam0", 40, 60);
  EXPECT_EQ(command("cam0", command_t::CMD_SNAPSHOT).result, reply_t::RESULT_OK);
  network_->settle();
  network_->finish();
  const Heard& heard = network_->of("cam0");
  const status_t& last = heard.statuses.back();
  EXPECT_EQ(figure(last, "frames.PAUSED"), "10");
  EXPECT_EQ(last.frames_rejected, 10);
  EXPECT_EQ(last.sequence_gaps, 0) << "what was left out here was not lost on the way";
  EXPECT_EQ(figure(last, "commands.done"), "4");
  EXPECT_EQ(last.map_id, 2);
  EXPECT_TRUE(std::any_of(heard.statuses.begin(), heard.statuses.end(), [](const status_t& s) {
    return s.state == status_t::STATE_PAUSED && s.reason == static_cast<int>(Reason::kPaused);
  }));
  EXPECT_TRUE(std::any_of(heard.statuses.begin(), heard.statuses.end(), [](const status_t& s) {
    return s.reason == static_cast<int>(Reason::kMapReset) && s.level == status_t::LEVEL_OK;
  }));
  EXPECT_EQ(heard.map.map().map_id(), 2);
  EXPECT_FALSE(heard.map.is_stale());
}

TEST_F(MappingServerCommand, AsAWholeAllCameras) {
  open(lossless());
  for (const char* camera : {"front", "back"}) calibrate(camera);
  for (const char* camera : {"front", "back"}) publish(camera, 0, 5);
  EXPECT_EQ(command("server", command_t::CMD_PAUSE).message.substr(0, 5), "back:");
  for (const char* camera : {"front", "back"}) publish(camera, 5, 8);
  expect_poses("front", 5);
  expect_poses("back", 5);
  EXPECT_EQ(command("back", command_t::CMD_RESUME).result, reply_t::RESULT_OK);
  for (const char* camera : {"front", "back"}) publish(camera, 8, 10);
  expect_poses("front", 5, "the other one was resumed");
  expect_poses("back", 7);
  EXPECT_FALSE(network_->server->told_to_stop());
}

TEST_F(MappingServerCommand, OfANamedCameraTheServerIsThereToo) {
  ServerConfig config = lossless();
  config.camera = "cam0";
  open(config);
  calibrate("cam0");
  publish("cam0", 0, 2);
  EXPECT_EQ(command("server", command_t::CMD_PAUSE).result, reply_t::RESULT_OK);
  EXPECT_EQ(command("cam0", command_t::CMD_SHUTDOWN).result, reply_t::RESULT_UNSUPPORTED);
  EXPECT_EQ(command("server", command_t::CMD_SHUTDOWN).result, reply_t::RESULT_OK);
  for (int i = 0; i < 5000 && !network_->server->told_to_stop(); ++i)
    std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(network_->server->told_to_stop());
}

TEST_F(MappingServerCommand, OverALongerNetworkNobodyWithoutASecret) {
  ServerConfig config = lossless();
  config.lcm_url = "udpm://239.255.76.67:7667?ttl=1";
  open(config);
  calibrate("cam0");
  publish("cam0", 0, 2);
  for (const char* camera : {"cam0", "server"}) {
    const reply_t reply = command(camera, command_t::CMD_PAUSE);
    EXPECT_EQ(reply.result, reply_t::RESULT_DENIED);
    EXPECT_EQ(static_cast<Reason>(reply.reason), Reason::kSecretWanted);
  }
  publish("cam0", 2, 4);
  expect_poses("cam0", 4);
  network_->finish();
  EXPECT_NE(figure(network_->of("cam0").statuses.back(), "commands.refused.SECRET_WANTED"), "");
  ASSERT_FALSE(network_->own.statuses.empty());
  EXPECT_NE(figure(network_->own.statuses.back(), "commands.refused.SECRET_WANTED"), "");
}

TEST_F(MappingServerCommand, ABadSecretIsSaidAtTheStart) {
  ServerConfig config;
  config.secret_file = "/nowhere/secret";
  EXPECT_THROW(open(config), std::invalid_argument);
}

}  // namespace
}  // namespace eifmap
