// Several cameras on one server: each as if it were alone.
#include <gtest/gtest.h>

#include "convert/feature_parts.h"
#include "sequence/temporary_folder.h"
#include "server/held.h"
#include "server/server_network.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

FeatureFrame frame_of(const std::string& camera, const SyntheticStream& stream, int i) {
  FeatureFrame frame = stream.frame(i);
  frame.camera = camera;
  return frame;
}

void publish_garbage(Network& network, const std::string& camera) {
  const std::vector<std::uint8_t> bytes(200, 0xee);
  for (const ChannelKind kind :
       {ChannelKind::kCalibration, ChannelKind::kImage, ChannelKind::kFeatures,
        ChannelKind::kMeasurement, ChannelKind::kRelativeRequest, ChannelKind::kMapRequest})
    network.publish({camera, kind}, bytes);
}

// What a camera's map came to.
struct Outcome {
  std::vector<FrameResult> poses;
  std::int64_t digest = 0, seq = 0;
};

Outcome outcome_of(Network& network, const std::string& camera) {
  Heard& heard = network.of(camera);
  EXPECT_FALSE(heard.map.is_stale()) << camera;
  EXPECT_EQ(heard.statuses.back().map_digest, heard.map.map().digest());
  return {heard.poses, heard.map.map().digest(), heard.map.map().seq()};
}

void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.digest, b.digest);
  EXPECT_EQ(a.seq, b.seq);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].seq, b.poses[i].seq);
    EXPECT_EQ(a.poses[i].state, b.poses[i].state);
    EXPECT_EQ(a.poses[i].map_from_camera.translation, b.poses[i].map_from_camera.translation);
    EXPECT_EQ(a.poses[i].map_from_camera.rotation.coeffs(),
              b.poses[i].map_from_camera.rotation.coeffs());
    EXPECT_EQ(a.poses[i].covariance, b.poses[i].covariance);
    EXPECT_EQ(a.poses[i].map_seq, b.poses[i].map_seq);
  }
}

constexpr int kFrames = 40;

Outcome alone(const std::string& camera, const SyntheticStream& stream) {
  Network network(lossless());
  network.publish(synthetic_camera(), camera);
  for (int i = 0; i < kFrames; ++i) network.publish(frame_of(camera, stream, i));
  network.settle();
  network.finish();
  return outcome_of(network, camera);
}

TEST(MappingServer, EachCamerasMapIsWhatItIsAlone) {
  const SyntheticStream first(1), second(2);
  Network network(lossless());
  for (const char* camera : {"first", "second"}) network.publish(synthetic_camera(), camera);
  for (int i = 0; i < kFrames; ++i) {
    network.publish(frame_of("first", first, i));
    network.publish(frame_of("second", second, i));
    publish_garbage(network, "third");
  }
  network.settle();
  network.finish();
  const Outcome a = outcome_of(network, "first"), b = outcome_of(network, "second");
  expect_same(a, alone("first", first));
  expect_same(b, alone("second", second));
  EXPECT_EQ(a.poses.back().state, TrackingState::kTracking);
  EXPECT_EQ(b.poses.back().state, TrackingState::kTracking);
  EXPECT_NE(a.digest, b.digest);
  for (const char* camera : {"first", "second"}) {
    const status_t& last = network.of(camera).statuses.back();
    EXPECT_EQ(last.frames_received, kFrames);
    EXPECT_EQ(last.frames_processed, kFrames);
    EXPECT_EQ(last.bad_messages, 0);
    EXPECT_EQ(last.reason, 0);
  }
  const status_t& third = network.of("third").statuses.back();
  EXPECT_EQ(third.frames_rejected, 2 * kFrames);
  EXPECT_GT(third.bad_messages, 0);
  EXPECT_TRUE(network.of("third").poses.empty());
}

TEST(MappingServer, AFloodOfOneCameraHoldsUpNoOther) {
  constexpr int kFlood = 60;
  ServerConfig config = lossless();
  config.max_queued_mib = 1;  // about ten frames
  const SyntheticStream stream;
  Held held;
  Network network(config, {}, [&held](const std::string& camera, std::string_view, bool) {
    if (camera == "flood") held.wait();
  });
  for (const char* camera : {"flood", "calm"}) network.publish(synthetic_camera(), camera);
  for (int i = 0; i < kFlood; ++i) network.publish(frame_of("flood", stream, i));
  for (int i = 0; i < kFrames && network.of("calm").pose_count == i; ++i) {
    network.publish(frame_of("calm", stream, i));
    for (int t = 0; t < 20000 && network.of("calm").pose_count <= i; ++t)
      std::this_thread::sleep_for(1ms);
    EXPECT_LE(network.server->statuses().size(), 3u) << "asked beside the mapping, as metrics are";
  }
  EXPECT_EQ(network.of("calm").pose_count, kFrames) << "while the other camera's inbox is full";
  EXPECT_EQ(network.of("flood").pose_count, 0);
  held.release();
  network.settle();
  network.publish(frame_of("flood", stream, kFlood));
  network.settle();
  network.finish();
  const status_t& calm = network.of("calm").statuses.back();
  EXPECT_EQ(calm.frames_processed, kFrames);
  EXPECT_EQ(calm.frames_dropped, 0);
  const status_t& flood = network.of("flood").statuses.back();
  EXPECT_EQ(flood.frames_received, kFlood + 1);
  EXPECT_GT(flood.frames_dropped, 0);
  EXPECT_EQ(flood.frames_processed + flood.frames_dropped, kFlood + 1);
  EXPECT_EQ(flood.sequence_gaps, 0) << "what the server drops is no loss of the network";
}

TEST(MappingServer, MoreCamerasThanItMayMapAreRefused) {
  ServerConfig config = lossless();
  config.max_cameras = 2;
  config.status_period_s = 0.05;
  const SyntheticStream stream;
  std::vector<std::string> told;  // one call at a time
  Network network(config, [&told](const status_t& status) {
    if (status.camera.empty()) told.push_back(status.message);
  });
  for (const char* camera : {"a", "b", "c", "d"}) network.publish(synthetic_camera(), camera);
  for (int i = 0; i < kFrames; ++i) {
    for (const char* camera : {"a", "b", "c"}) network.publish(frame_of(camera, stream, i));
    if (i > 0) continue;
    for (const feature_frame_t& part : split_features(frame_of("d", stream, i), 1400))
      network.publish({"d", ChannelKind::kFeatures}, encode(part));
  }
  network.settle();
  network.finish();
  for (const char* camera : {"a", "b"}) {
    EXPECT_EQ(network.of(camera).statuses.back().frames_processed, kFrames);
    EXPECT_EQ(network.of(camera).statuses.back().frames_rejected, 0);
  }
  for (const char* camera : {"c", "d"}) EXPECT_FALSE(network.has_heard_of(camera)) << camera;
  const status_t& own = network.own.statuses.back();
  EXPECT_EQ(own.state, status_t::STATE_STOPPING);
  EXPECT_EQ(own.reason, static_cast<std::int16_t>(Reason::kTooManyCameras));
  EXPECT_EQ(own.frames_rejected, kFrames + 1) << "a frame in parts is one";
  EXPECT_EQ(figure(own, "cameras.mapped"), "2");
  EXPECT_EQ(figure(own, "cameras.refused"), "2");
  ASSERT_GE(told.size(), 2u) << "of the refusals, and of the stop";
  EXPECT_NE(told.front().find("camera "), std::string::npos) << told.front();
}

// What its mapper throws, in a frame or in a keyframe's thread, costs a camera frames or its map.
TEST(MappingServer, AFaultOfOneCamerasMapperLeavesTheOthersAlone) {
  const SyntheticStream stream;
  std::atomic<int> thrown = 0;
  Network network(lossless(), {},
                  [&thrown](const std::string& camera, std::string_view step, bool begins) {
                    if (camera != "faulty" || !begins || step != "keyframe") return;
                    ++thrown;
                    throw std::runtime_error("a fault on purpose");
                  });
  for (const char* camera : {"faulty", "sound"}) network.publish(synthetic_camera(), camera);
  for (int i = 0; i < kFrames; ++i)
    for (const char* camera : {"faulty", "sound"}) network.publish(frame_of(camera, stream, i));
  network.settle();
  network.finish();
  EXPECT_GT(thrown, 0);
  EXPECT_GT(network.of("faulty").statuses.back().frames_rejected, 0);
  EXPECT_EQ(network.of("faulty").statuses.back().frames_received, kFrames);
  expect_same(outcome_of(network, "sound"), alone("sound", stream));
}

TEST(MappingServer, StopsSeveralCamerasWhoseInboxesAreFull) {
  ServerConfig config = lossless();
  config.max_queued_mib = 1;
  const SyntheticStream stream;
  Network network(config);
  const std::vector<std::string> cameras{"a", "b", "c"};
  for (const std::string& camera : cameras) network.publish(synthetic_camera(), camera);
  for (int i = 0; i < kFrames; ++i)
    for (const std::string& camera : cameras) network.publish(frame_of(camera, stream, i));
  network.wait_until_handed_out();  // a camera that the server has not heard of has no inbox
  network.finish();
  for (const std::string& camera : cameras) {
    ASSERT_FALSE(network.of(camera).statuses.empty()) << camera;
    EXPECT_EQ(network.of(camera).statuses.back().state, status_t::STATE_STOPPING) << camera;
  }
  for (const status_t& own : network.own.statuses)
    EXPECT_NE(own.state, status_t::STATE_STOPPING) << "each camera has said it";
}

TEST(MappingServer, MapsOnlyTheCameraThatIsNamed) {
  ServerConfig config = lossless();
  config.camera = "a";
  const SyntheticStream stream;
  Network network(config);
  for (const char* camera : {"b", "a"}) {
    network.publish(synthetic_camera(), camera);
    network.publish(frame_of(camera, stream, 0));
  }
  network.settle();
  network.finish();
  EXPECT_EQ(network.of("a").statuses.back().frames_processed, 1);
  EXPECT_EQ(network.of("a").statuses.back().frames_rejected, 0);
  EXPECT_FALSE(network.has_heard_of("b"));
}

// One camera's results are in the folder, those of several in one each; a camera that never had a
// good frame has none.
TEST(MappingServer, WritesTheResultsOfEachCamera) {
  const SyntheticStream stream;
  for (const int num_cameras : {0, 1, 2}) {
    const TemporaryFolder folder;
    Network network(lossless());
    publish_garbage(network, "garbage");
    for (int c = 0; c < num_cameras; ++c) {
      const std::string camera = "cam" + std::to_string(c);
      network.publish(synthetic_camera(), camera);
      for (int i = 0; i < 3; ++i) network.publish(frame_of(camera, stream, i));
    }
    network.settle();
    network.server->stop();
    EXPECT_EQ(network.server->has_results(), num_cameras > 0);
    EXPECT_EQ(network.server->write_results(folder.path()).empty(), num_cameras > 0);
    EXPECT_EQ(std::filesystem::exists(folder.path() / "report.json"), num_cameras == 1);
    for (const char* camera : {"cam0", "cam1"})
      EXPECT_EQ(std::filesystem::exists(folder.path() / camera / "report.json"), num_cameras == 2);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "garbage"));
    network.finish();
  }
}

}  // namespace
}  // namespace eifmap
