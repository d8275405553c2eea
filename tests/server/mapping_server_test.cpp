// The whole server on an in-process network.
#include "server/mapping_server.h"

#include <gtest/gtest.h>

#include "decision.h"
#include "server/held.h"
#include "server/server_network.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

TEST(MappingServer, PublishesWhatTheMapperSaysToTheBit) {
  constexpr int kFrames = 40;
  const SyntheticStream stream;
  Network network(lossless());
  network.publish(synthetic_camera());
  for (int i = 0; i < kFrames; ++i) network.publish(stream.frame(i));
  network.settle();
  network.finish();

  Mapper mapper(synthetic_camera(), {});
  ASSERT_EQ(network.of("cam0").poses.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    const FrameResult expected = mapper.process(stream.frame(i));
    const FrameResult& pose = network.of("cam0").poses[static_cast<std::size_t>(i)];
    EXPECT_EQ(pose.time_us, expected.time_us);
    EXPECT_EQ(pose.seq, i);
    EXPECT_EQ(pose.state, expected.state);
    EXPECT_EQ(pose.source, expected.source);
    EXPECT_EQ(pose.reason, expected.reason);
    EXPECT_EQ(pose.map_from_camera.translation, expected.map_from_camera.translation);
    EXPECT_EQ(pose.map_from_camera.rotation.coeffs(), expected.map_from_camera.rotation.coeffs());
    EXPECT_EQ(pose.covariance, expected.covariance);
  }
  EXPECT_EQ(network.of("cam0").poses.back().state, TrackingState::kTracking);
  EXPECT_EQ(static_cast<std::int64_t>(network.of("cam0").map.map().keyframes().size()),
            mapper.statistics().keyframes);
  EXPECT_EQ(static_cast<std::int64_t>(network.of("cam0").map.map().landmarks().size()),
            mapper.statistics().landmarks);
  EXPECT_FALSE(network.of("cam0").map.is_stale());
  EXPECT_EQ(network.of("cam0").poses.back().map_seq, network.of("cam0").map.map().seq());

  const status_t& last = network.of("cam0").statuses.back();
  EXPECT_EQ(last.state, status_t::STATE_STOPPING);
  EXPECT_EQ(last.camera, "cam0");
  EXPECT_EQ(last.frames_received, kFrames);
  EXPECT_EQ(last.frames_processed, kFrames);
  EXPECT_EQ(last.frames_dropped, 0);
  EXPECT_EQ(last.sequence_gaps, 0);
  EXPECT_GT(last.parts_sent, 0);
}

// True positions, some of which are bad: the map becomes metric, which poses, status and map say.
TEST(MappingServer, BecomesMetricWithTheMeasurementsThatCome) {
  constexpr int kFrames = 60;
  const SyntheticStream stream;
  Network network(lossless());
  network.publish(synthetic_camera());
  std::int64_t sent = 0;
  for (int i = 0; i < kFrames; ++i) {
    AbsoluteMeasurement m;
    m.id = {9, i};
    m.time_us = stream.frame(i).time_us;
    m.position = {100, 200 + 0.1 * i, -30};
    m.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    network.publish(m), ++sent;
    if (i == 30) network.publish(m), ++sent;
    if (i == 31) m.id.seq = 100, m.position.z() += 30, network.publish(m), ++sent;
    if (i == 32)
      network.publish({"cam0", ChannelKind::kMeasurement}, std::vector<std::uint8_t>(9)), ++sent;
    network.publish(stream.frame(i));
  }
  network.settle();
  network.finish();
  ASSERT_EQ(network.of("cam0").poses.size(), static_cast<std::size_t>(kFrames));
  int metric = 0;
  for (const FrameResult& pose : network.of("cam0").poses) {
    metric += pose.map_epoch == 1;
    EXPECT_EQ(pose.scale.status == ScaleStatus::kFixed, pose.map_epoch == 1);
  }
  EXPECT_GT(metric, 20);
  EXPECT_LT(metric, kFrames - 5);
  const FrameResult& last = network.of("cam0").poses.back();
  EXPECT_NEAR(last.map_from_camera.translation.norm(), 0.1 * (kFrames - 1), 0.05);
  EXPECT_GT(last.scale.sigma, 0);
  const status_t& status = network.of("cam0").statuses.back();
  EXPECT_EQ(status.scale, status_t::SCALE_METRIC);
  EXPECT_EQ(status.metres_per_unit, last.scale.metres_per_unit);
  EXPECT_GT(status.sigma_log_scale, 0);
  EXPECT_EQ(figure(status, "measurements.arrived"), std::to_string(sent));
  EXPECT_EQ(figure(status, "measurements.refused.MEASUREMENT_REPEATED"), "1");
  EXPECT_EQ(figure(status, "measurements.refused.MEASUREMENT_GATED"), "1");
  EXPECT_EQ(figure(status, "measurements.refused.MALFORMED_MESSAGE"), "1");
  const auto number = [&status](const std::string& key) {
    return std::stoi(figure(status, "measurements." + key));
  };
  EXPECT_GT(number("position.used"), 40);
  EXPECT_EQ(number("position.used") + number("position.refused") + number("waiting"), sent - 1)
      << "all but the one that could not be read";
  EXPECT_EQ(status.bad_messages, 1);
  // What was put together from the parts is the metric map, and only that.
  EXPECT_EQ(network.of("cam0").map.map().map_epoch(), 1);
  EXPECT_FALSE(network.of("cam0").map.is_stale());
  const auto& keyframes = network.of("cam0").map.map().keyframes();
  const keyframe_t &first = keyframes.begin()->second, &newest = keyframes.rbegin()->second;
  const double moved_s = 1e-6 * static_cast<double>(newest.utime - first.utime);
  const Eigen::Vector3d moved = Eigen::Vector3d(newest.position) - Eigen::Vector3d(first.position);
  EXPECT_NEAR(moved.norm(), moved_s, 0.05);
}

// One that heard nothing of how the map came to be, and loses part of the answer.
TEST(MappingServer, ALateClientGetsTheMapByAsking) {
  const SyntheticStream stream;
  Network network(lossless());
  network.publish(synthetic_camera());
  for (int i = 0; i < 40; ++i) network.publish(stream.frame(i));
  network.settle();
  const std::int64_t seq = network.of("cam0").map.map().seq();
  std::mutex mutex;  // parts come in the dispatcher's thread
  MapFollower late(7);
  late.hear("cam0", network.of("cam0").map.map().server_epoch(), seq, {});
  network.also_take = [&, n = 0](const map_part_t& part) mutable {
    const std::lock_guard lock(mutex);
    if (n++ % 3 != 1) late.take(part, MapFollower::TimePoint{1h});
  };
  const auto ask = [&](int i) {
    const std::lock_guard lock(mutex);
    return late.ask(MapFollower::TimePoint{i * 2h}, 1);
  };
  for (int i = 1; i < 50; ++i) {
    const auto request = ask(i);
    if (!request) break;
    network.publish({"cam0", ChannelKind::kMapRequest}, encode(*request));
    network.settle();
    std::this_thread::sleep_for(2 * MapPublisher::kRepeat);
  }
  map_request_t broken{};
  broken.camera = "another";
  broken.requester = 1;
  network.publish({"cam0", ChannelKind::kMapRequest}, encode(broken));
  network.settle();
  network.finish();
  EXPECT_FALSE(late.is_stale());
  EXPECT_EQ(encode(late.map().whole()), encode(network.of("cam0").map.map().whole()));
  EXPECT_GE(late.counts().requests, 2);
  const status_t& last = network.of("cam0").statuses.back();
  EXPECT_EQ(last.map_seq, seq);
  EXPECT_EQ(last.map_digest, late.map().digest());
  EXPECT_EQ(figure(last, "map_requests"), std::to_string(late.counts().requests));
  EXPECT_EQ(last.bad_messages, 1);
}

TEST(MappingServer, PartsOfTheMapBeforeAreDropped) {
  ServerConfig config = lossless();
  config.map_bytes_per_s = 1000;  // after the first burst, a part in half a minute
  const SyntheticStream stream;
  Camera changed = synthetic_camera();
  changed.fx = 510;
  Network network(config);
  network.publish(synthetic_camera());
  for (int i = 0; i < 120; ++i) network.publish(stream.frame(i));
  network.publish(changed);
  for (int i = 0; i < 120; ++i) {
    FeatureFrame frame = stream.frame(i);
    frame.calibration_id = changed.id();
    network.publish(frame);
  }
  for (int i = 0; i < 60000 && network.of("cam0").pose_count < 240; ++i)
    std::this_thread::sleep_for(1ms);
  network.finish();
  const status_t& last = network.of("cam0").statuses.back();
  EXPECT_EQ(last.frames_processed, 240);
  const std::size_t left = last.message.find("; ");
  ASSERT_NE(left, std::string::npos) << last.message;
  EXPECT_NE(last.message.find("could not be sent in time"), std::string::npos) << last.message;
  EXPECT_GT(std::stoi(figure(last, "parts_dropped")), std::stoi(last.message.substr(left + 2)))
      << "those of the first map and those left at the end";
}

// Whatever throws around the mapping, every frame is counted and the server says its last word.
TEST(MappingServer, OutlivesWhatItsSurroundingsThrow) {
  class BrittleBus : public Bus {
   public:
    void subscribe(const std::string&, int, Handler handler) override {
      handlers_.push_back(std::move(handler));
    }
    void unsubscribe_all() override { handlers_.clear(); }
    bool publish(const std::string& channel, Bytes bytes) override {
      const std::lock_guard lock(mutex_);
      if (parse_channel(channel)->camera == kNoCamera) return true;
      if (parse_channel(channel)->kind != ChannelKind::kStatus)
        throw std::runtime_error("the wire is cut");
      last = decode_status(bytes).value;
      if (++statuses_ % 2 == 1) throw std::runtime_error("the wire is cut");
      return true;
    }
    bool receive(std::chrono::milliseconds) override { return true; }
    void deliver(const std::string& channel, Bytes bytes) { handlers_.front()(channel, bytes); }

    status_t last{};

   private:
    std::mutex mutex_;
    std::vector<Handler> handlers_;
    int statuses_ = 0;
  } bus;
  ServerConfig config = lossless();
  config.status_period_s = 0.01;
  int told = 0;
  const auto faulty = [&told](const status_t&) {
    ++told;
    throw std::runtime_error("nobody listens");
  };
  const SyntheticStream stream;
  MappingServer server(config, bus, faulty);
  bus.deliver("eifmap.cam0.calibration",
              encode(to_message(NamedCamera{1, "cam0", synthetic_camera()})));
  for (int i = 0; i < 30; ++i)
    bus.deliver("eifmap.cam0.features", encode(to_message(stream.frame(i))));
  ASSERT_TRUE(server.wait_until_idle(60s));
  server.stop();
  EXPECT_GT(told, 0);
  EXPECT_EQ(bus.last.frames_processed, 30);
  EXPECT_EQ(bus.last.frames_rejected, 0);
  EXPECT_EQ(bus.last.bad_messages, 0);
  std::map<std::string, std::string> figures;
  for (const diagnostic_t& entry : bus.last.diagnostics) figures[entry.key] = entry.value;
  EXPECT_EQ(figures["internal_errors"], std::to_string(told - 1)) << "the last follows this status";
  EXPECT_GE(std::stoi(figures["send_failures"]), 30);
  for (const char* key : {"moving.now", "moving.most", "moving.frames"})
    EXPECT_EQ(figures[key], "0") << key;
}

TEST(MappingServer, NewestAccountsForEveryFrame) {
  constexpr int kFrames = 200;
  const SyntheticStream stream;
  Held held;  // else a mapper that is faster than the publisher drops none
  Network network(ServerConfig{}, {},
                  [&held](const std::string&, std::string_view, bool) { held.wait(); });
  network.publish(synthetic_camera());
  for (int i = 0; i < kFrames; ++i) network.publish(stream.frame(i, 0.02));
  network.wait_until_handed_out();
  held.release();
  network.settle();
  network.finish();
  const status_t& last = network.of("cam0").statuses.back();
  EXPECT_EQ(last.frames_received, kFrames);
  EXPECT_EQ(last.frames_processed + last.frames_dropped, kFrames);
  EXPECT_GT(last.frames_dropped, 0) << "200 frames at once must not all be mapped";
  EXPECT_EQ(last.sequence_gaps, 0) << "what the server drops is no loss of the network";
  ASSERT_FALSE(network.of("cam0").poses.empty());
  EXPECT_EQ(network.of("cam0").poses.back().seq, kFrames - 1)
      << "the newest is never the one dropped";
  EXPECT_EQ(static_cast<std::int64_t>(network.of("cam0").poses.size()), last.frames_processed);
}

// With time between the frames, and without: what is counted is not decided by timing.
TEST(MappingServer, FramesAreCountedUntilAKeyframeIsAdopted) {
  constexpr int kFrames = 40;
  const SyntheticStream stream;
  ServerConfig config = lossless();
  config.handover_frames = 3;
  std::vector<FrameResult> poses[2];
  for (const bool idle : {false, true}) {
    Network network(config);
    network.publish(synthetic_camera());
    for (int i = 0; i < kFrames; ++i) {
      network.publish(stream.frame(i));
      if (idle) network.settle();
    }
    network.settle();
    network.finish();
    EXPECT_FALSE(network.of("cam0").map.is_stale());
    poses[idle] = network.of("cam0").poses;
  }
  ASSERT_EQ(poses[0].size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(poses[1].size(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(poses[0][i].map_seq, poses[1][i].map_seq) << i;
    EXPECT_EQ(decision_of(poses[0][i]), decision_of(poses[1][i])) << i;
  }
  EXPECT_GT(poses[0].back().map_seq, 3);
}

// A keyframe that is done leaves while no frame comes, and what is left at the stop.
TEST(MappingServer, ADoneKeyframeWaitsForNoFrame) {
  const SyntheticStream stream;
  Network network(ServerConfig{});
  network.publish(synthetic_camera());
  std::int64_t published = 0;
  for (int i = 0; i < 40; ++i) {
    network.publish(stream.frame(i));
    network.settle();
  }
  network.finish();
  for (const FrameResult& pose : network.of("cam0").poses)
    published = std::max(published, pose.map_seq);
  EXPECT_GT(published, 3);
  EXPECT_FALSE(network.of("cam0").map.is_stale());
  EXPECT_EQ(network.of("cam0").statuses.back().num_keyframes,
            static_cast<int>(network.of("cam0").map.map().keyframes().size()));
}

TEST(MappingServer, StatusSaysWhatIsWrong) {
  const SyntheticStream stream;
  Network network(lossless());
  network.publish(stream.frame(0));
  network.publish({"cam0", ChannelKind::kFeatures}, std::vector<std::uint8_t>(100, 7));
  network.publish(synthetic_camera());
  network.publish({"cam0", ChannelKind::kFeatures}, std::vector<std::uint8_t>(100, 7));
  network.publish(stream.frame(1));
  network.settle();
  network.finish();
  bool no_calibration = false;
  for (const status_t& status : network.of("cam0").statuses)
    if (status.reason == static_cast<std::int16_t>(Reason::kNoCalibration)) {
      no_calibration = true;
      EXPECT_EQ(status.level, status_t::LEVEL_ERROR);
      EXPECT_NE(status.message, "");
      EXPECT_NE(status.hint, "");
    }
  EXPECT_TRUE(no_calibration);
  const status_t& last = network.of("cam0").statuses.back();
  EXPECT_EQ(last.frames_processed, 1);
  EXPECT_EQ(last.frames_rejected, 3) << "two without calibration, one malformed";
  EXPECT_EQ(last.bad_messages, 1);
  EXPECT_EQ(network.of("cam0").poses.size(), 1u) << "rejected frames have no pose";
}

TEST(MappingServer, StatusHasTheNumbersOfEachPublisher) {
  Network network(lossless());
  network.publish(synthetic_camera());
  const SyntheticStream stream;
  const auto publish = [&](std::int64_t publisher, std::initializer_list<int> seqs) {
    for (const int seq : seqs) {
      FeatureFrame frame = stream.frame(seq);
      frame.publisher = publisher;
      network.publish(frame);
    }
  };
  publish(7, {0, 1, 3});
  publish(8, {4, 6, 6, 9});
  network.settle();
  network.finish();
  const auto said = [&](const char* key) {
    return figure(network.of("cam0").statuses.back(), key);
  };
  EXPECT_EQ(said("publisher_restarts"), "1");
  EXPECT_EQ(said("publisher.id"), "8");
  EXPECT_EQ(said("publisher.frames"), "4");
  EXPECT_EQ(said("publisher.missing"), "3");
  EXPECT_EQ(said("publisher.duplicates"), "1");
  EXPECT_NE(said("publisher.clock_offset_us"), "");
  EXPECT_EQ(said("publisher.before_1.id"), "7");
  EXPECT_EQ(said("publisher.before_1.missing"), "1");
  EXPECT_EQ(network.of("cam0").statuses.back().sequence_gaps, 4);
}

TEST(MappingServer, StopsWhileTheInboxIsFull) {
  ServerConfig config = lossless();
  config.camera = "cam0";     // so that the receiving thread waits for room
  config.max_queued_mib = 1;  // about ten frames
  const SyntheticStream stream;
  Network network(config);
  network.publish(synthetic_camera());
  for (int i = 0; i < 100; ++i) network.publish(stream.frame(i));
  // Before the camera has its inbox there is none to be full. What the server says is heard only
  // after these frames.
  for (int i = 0; i < 60000 && network.server->statuses().size() < 2; ++i)
    std::this_thread::sleep_for(1ms);
  network.finish();
  ASSERT_FALSE(network.of("cam0").statuses.empty());
  EXPECT_EQ(network.of("cam0").statuses.back().state, status_t::STATE_STOPPING);
}

TEST(MappingServer, StatusComesWithoutAnyInput) {
  ServerConfig config;
  config.status_period_s = 0.02;
  Network network(config);
  for (int i = 0; i < 60000 && network.own.status_count < 3; ++i) std::this_thread::sleep_for(1ms);
  network.finish();
  EXPECT_GE(network.own.statuses.size(), 3u);
  EXPECT_EQ(network.own.statuses.front().state, status_t::STATE_WAITING);
  EXPECT_NE(network.own.statuses.front().hint, "");
  EXPECT_EQ(network.own.statuses.back().state, status_t::STATE_STOPPING);
}

// One that asks for what is not there is told so, one that cannot be read is counted.
TEST(MappingServer, AnswersWhereAKeyframeIsSeenFromAnother) {
  constexpr int kFrames = 40;
  const SyntheticStream stream;
  Network network(lossless());
  network.publish(synthetic_camera());
  const auto ask = [&](std::int64_t id, std::int64_t map_id, std::int64_t a, std::int64_t b) {
    network.publish({"cam0", ChannelKind::kRelativeRequest},
                    encode(to_message(RelativeRequest{1, 77, id, "cam0", map_id, a, b})));
  };
  ask(0, 1, 0, 1);  // before there is a map
  for (int i = 0; i < kFrames; ++i) network.publish(stream.frame(i));
  network.settle();
  ask(1, 1, 0, 2);
  ask(2, 1, 0, 1000);
  ask(3, 2, 0, 2);
  network.publish({"cam0", ChannelKind::kRelativeRequest}, std::vector<std::uint8_t>{1, 2, 3});
  network.settle();
  network.finish();

  Mapper mapper(synthetic_camera(), {});
  for (int i = 0; i < kFrames; ++i) mapper.process(stream.frame(i));
  const auto expected = mapper.relative_pose(0, 2);
  ASSERT_TRUE(expected);
  ASSERT_EQ(network.answers.size(), 4u);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(network.answers[k].request.requester, 77);
    EXPECT_EQ(network.answers[k].request.request_id, k);
    EXPECT_EQ(network.answers[k].reason, k == 1 ? Reason::kNone : Reason::kKeyframeUnknown) << k;
  }
  const RelativeAnswer& answer = network.answers[1];
  EXPECT_EQ(answer.view.a_from_b.translation, expected->a_from_b.translation);
  EXPECT_EQ(answer.view.covariance, expected->covariance);
  EXPECT_EQ(answer.map_seq, network.of("cam0").map.map().seq());
  EXPECT_GE(network.of("cam0").statuses.back().bad_messages, 1);
}

}  // namespace
}  // namespace eifmap
