// A whole server on an in-process network, for tests that publish to it and read what it says.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bus/lcm_bus.h"
#include "bus/link.h"
#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/map_message.h"
#include "convert/measurement_message.h"
#include "convert/relative_message.h"
#include "convert/status_message.h"
#include "published/map_follower.h"
#include "server/mapping_server.h"

namespace eifmap {

using namespace std::chrono_literals;

// What is said of one camera.
struct Heard {
  std::vector<FrameResult> poses;
  MapFollower map{1};
  std::vector<status_t> statuses;
  std::atomic<int> pose_count = 0, status_count = 0;
};

// One memq:// network with a server, a publisher and a listener on it, and a thread that hands the
// messages out.
class Network {
 public:
  explicit Network(const ServerConfig& config, MappingServer::OnChange on_change = {},
                   MappingServer::OnStep on_step = {})
      : lcm_(std::make_shared<lcm::LCM>("memq://")), bus_(lcm_), listener_(lcm_) {
    listen(ChannelKind::kPose, [this](Bytes bytes) {
      const Decoded<PublishedPose> pose = decode_pose(bytes);
      EXPECT_TRUE(pose.ok()) << pose.detail;
      Heard& heard = of(pose.value.origin.camera);
      heard.poses.push_back(pose.value.result);
      ++heard.pose_count;
    });
    listen(ChannelKind::kMap, [this](Bytes bytes) {
      EXPECT_LE(bytes.size(), static_cast<std::size_t>(kThisHost.message_bytes));
      const Decoded<map_part_t> part = decode_map_part(bytes);
      EXPECT_TRUE(part.ok()) << part.detail;
      of(part.value.camera).map.take(part.value, {});
      if (also_take) also_take(part.value);
    });
    listen(ChannelKind::kRelative, [this](Bytes bytes) {
      const Decoded<RelativeAnswer> answer = decode_relative(bytes);
      EXPECT_TRUE(answer.ok()) << answer.detail;
      answers.push_back(answer.value);
    });
    listen(ChannelKind::kStatus, [this](Bytes bytes) {
      const Decoded<status_t> status = decode_status(bytes);
      EXPECT_TRUE(status.ok()) << status.detail;
      Heard& heard = status.value.camera.empty() ? own : of(status.value.camera);
      heard.statuses.push_back(status.value);
      ++heard.status_count;
    });
    listener_.subscribe(channel_pattern("", ChannelKind::kReply), 0,
                        [this](const std::string&, Bytes bytes) {
                          if (on_reply) on_reply(bytes);
                        });
    listener_.subscribe(literal_pattern(kMarker), 0,
                        [this](const std::string&, Bytes) { ++markers_heard_; });
    server.emplace(config, bus_, std::move(on_change), std::move(on_step));
    dispatcher_ = std::thread([this] {
      while (!done_) bus_.receive(10ms);
    });
  }
  ~Network() { finish(); }

  void publish(const Channel& channel, Bytes bytes) {
    bus_.publish(channel_name(channel.camera, channel.kind), bytes);
  }
  void publish(const FeatureFrame& frame) {
    publish({frame.camera, ChannelKind::kFeatures}, encode(to_message(frame)));
  }
  void publish(const AbsoluteMeasurement& measurement) {
    publish({"cam0", ChannelKind::kMeasurement},
            encode(to_message(NamedMeasurement{"cam0", measurement})));
  }
  void publish(const Camera& camera, const std::string& name = "cam0") {
    publish({name, ChannelKind::kCalibration}, encode(to_message(NamedCamera{1, name, camera})));
  }

  // Waits until the server has all that was published, and the lists below what it said before.
  // memq:// hands out in the order of publishing, whoever publishes.
  void wait_until_handed_out() {
    const int marker = ++markers_;
    bus_.publish(kMarker, {});
    for (int i = 0; i < 60000 && markers_heard_ < marker; ++i) std::this_thread::sleep_for(1ms);
    ASSERT_GE(markers_heard_, marker);
  }

  // Waits until the server has mapped all that was published, and what it said of that is heard.
  void settle() {
    wait_until_handed_out();
    ASSERT_TRUE(server->wait_until_idle(60s));
    wait_until_handed_out();
  }

  // Stops the server and waits for its last words: the lists below may then be read.
  void finish() {
    if (!dispatcher_.joinable()) return;
    server->stop();
    wait_until_handed_out();
    bool stopped = own.statuses.empty() || own.statuses.back().state == status_t::STATE_STOPPING;
    for (const auto& [camera, heard] : heard_) {
      stopped = !heard.statuses.empty() && heard.statuses.back().state == status_t::STATE_STOPPING;
      EXPECT_TRUE(stopped) << camera;
    }
    EXPECT_TRUE(stopped);
    done_ = true;
    dispatcher_.join();
    server.reset();  // while its bus is still there
  }

  Heard& of(const std::string& camera) {
    const std::lock_guard lock(mutex_);
    return heard_[camera];
  }
  bool has_heard_of(const std::string& camera) {
    const std::lock_guard lock(mutex_);
    return heard_.contains(camera);
  }

 private:
  std::mutex mutex_;
  std::map<std::string, Heard> heard_;

 public:
  std::optional<MappingServer> server;
  Heard own;  // the server's word of itself
  std::function<void(const map_part_t&)> also_take;
  std::function<void(Bytes)> on_reply;  // in the thread that hands out; set it before commanding
  std::vector<RelativeAnswer> answers;

 private:
  static constexpr const char* kMarker = "network.marker";  // that no server listens to

  void listen(ChannelKind kind, std::function<void(Bytes)> handler) {
    listener_.subscribe(channel_pattern("", kind), 0,
                        [handler](const std::string&, Bytes bytes) { handler(bytes); });
  }

  std::shared_ptr<lcm::LCM> lcm_;
  LcmBus bus_, listener_;
  std::atomic<bool> done_ = false;
  std::atomic<int> markers_ = 0, markers_heard_ = 0;
  std::thread dispatcher_;
};

inline ServerConfig lossless() {
  ServerConfig config;
  config.input = InputMode::kLossless;
  return config;
}

inline std::string figure(const status_t& status, const std::string& key) {
  for (const diagnostic_t& entry : status.diagnostics)
    if (entry.key == key) return entry.value;
  return "";
}

}  // namespace eifmap
