// A server whose maps are kept on the disk: ended, and started again.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <set>

#include "sequence/temporary_folder.h"
#include "server/check_map.h"
#include "server/server_network.h"
#include "support/feature_world.h"
#include "support/file_bytes.h"

namespace eifmap {
namespace {

using test::read_bytes;

const SyntheticStream kWorld(3);

ServerConfig kept_in(const TemporaryFolder& folder) {
  ServerConfig config = lossless();
  config.maps_folder = folder.path() / "maps";
  return config;
}

std::filesystem::path file_of(const ServerConfig& config, int map = 1) {
  return std::filesystem::path(config.maps_folder) / "cam0" /
         ("map-" + std::to_string(map) + ".eifmap");
}

void publish(Network& network, int from, int to) {
  for (int i = from; i < to; ++i) network.publish(kWorld.frame(i));
}

std::set<std::int64_t> keyframes_of(const PublishedMap& map) {
  std::set<std::int64_t> ids;
  for (const auto& [id, keyframe] : map.keyframes()) ids.insert(id);
  return ids;
}

struct Life {
  std::set<std::int64_t> keyframes;
  std::int64_t seq = 0, map_id = 0, epoch = 0;
  std::vector<FrameResult> poses;
  status_t last;
};

// Frames from..to of a server from its start to its end.
Life live(const ServerConfig& config, int from, int to) {
  Network network(config);
  network.publish(synthetic_camera());
  publish(network, from, to);
  network.settle();
  network.finish();
  Heard& heard = network.of("cam0");
  EXPECT_FALSE(heard.map.is_stale());
  EXPECT_EQ(heard.statuses.back().map_digest, heard.map.map().digest());
  const PublishedMap& map = heard.map.map();
  return {keyframes_of(map),
          map.seq(),
          heard.statuses.back().map_id,
          heard.statuses.back().map_epoch,
          heard.poses,
          heard.statuses.back()};
}

TEST(StoredMaps, ARestartedServerGoesOnWithThem) {
  const TemporaryFolder folder;
  const ServerConfig config = kept_in(folder);
  const Life first = live(config, 0, 40);
  EXPECT_EQ(first.last.map_is_safe, 1);
  EXPECT_TRUE(check_map(file_of(config), false).ok);

  // The map is published before any frame has come.
  const Life looked = live(config, 0, 0);
  EXPECT_EQ(looked.keyframes, first.keyframes);
  EXPECT_EQ(looked.map_id, first.map_id);
  EXPECT_GT(looked.seq, first.seq);

  const Life second = live(config, 40, 80);
  ASSERT_EQ(second.poses.size(), 40u);
  EXPECT_EQ(second.poses[0].source, PoseSource::kRelocalized);
  EXPECT_EQ(second.map_id, first.map_id);
  EXPECT_GE(second.epoch, first.epoch);
  EXPECT_TRUE(std::includes(second.keyframes.begin(), second.keyframes.end(),
                            first.keyframes.begin(), first.keyframes.end()));
  EXPECT_GT(second.keyframes.size(), first.keyframes.size());
  EXPECT_TRUE(check_map(file_of(config), false).ok);
}

TEST(StoredMaps, WhereTheyOnlyServeToLocalizeTheyStayAsTheyAre) {
  const TemporaryFolder folder;
  ServerConfig config = kept_in(folder);
  live(config, 0, 40);
  const std::vector<std::uint8_t> before = read_bytes(file_of(config));
  config.mapper.localize_only = true;
  const Life localized = live(config, 10, 60);
  EXPECT_EQ(read_bytes(file_of(config)), before);
  int tracked = 0;
  for (const FrameResult& pose : localized.poses) tracked += pose.state == TrackingState::kTracking;
  EXPECT_GE(tracked, 30);
  EXPECT_EQ(localized.poses.back().map_id, 1);
}

TEST(StoredMaps, WithNoneToLocalizeInNoneIsMade) {
  const TemporaryFolder folder;
  ServerConfig config = kept_in(folder);
  config.mapper.localize_only = true;
  const Life none = live(config, 0, 20);
  EXPECT_TRUE(none.keyframes.empty());
  EXPECT_EQ(none.poses.back().reason, Reason::kNotRelocalized);
  EXPECT_FALSE(std::filesystem::exists(file_of(config)));
}

// A disk that is full, as a limit of the files' sizes: mapping goes on, and it is said.
TEST(StoredMaps, AFullDiskCostsNothingButSafety) {
  const TemporaryFolder folder;
  const ServerConfig config = kept_in(folder);
  Network network(config);
  network.publish(synthetic_camera());
  publish(network, 0, 20);
  network.settle();
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  getrlimit(RLIMIT_FSIZE, &old);
  const rlimit full{std::filesystem::file_size(file_of(config)) + 100, old.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  publish(network, 20, 40);
  network.settle();
  const std::vector<std::uint8_t> meanwhile = read_bytes(file_of(config));
  setrlimit(RLIMIT_FSIZE, &old);
  publish(network, 40, 60);
  network.settle();
  network.finish();
  Heard& heard = network.of("cam0");
  EXPECT_EQ(heard.poses.size(), 60u);
  EXPECT_EQ(heard.statuses.back().map_is_safe, 1);
  EXPECT_NE(figure(heard.statuses.back(), "maps.not_saved"), "0");
  bool was_unsafe = false;
  for (const status_t& status : heard.statuses)
    was_unsafe = was_unsafe || (status.map_is_safe == 0 &&
                                status.reason == static_cast<int>(Reason::kMapNotSaved));
  EXPECT_TRUE(was_unsafe);
  EXPECT_EQ(keyframes_of(heard.map.map()).size(),
            static_cast<std::size_t>(heard.map.map().keyframes().size()));
  EXPECT_TRUE(check_map(file_of(config), false).ok);
  const std::filesystem::path copy = folder.path() / "meanwhile";
  test::write_bytes(copy, meanwhile);
  EXPECT_TRUE(check_map(copy, false).ok) << "what was safe stayed so";
}

TEST(StoredMaps, AFolderInUseIsNotShared) {
  const TemporaryFolder folder;
  const ServerConfig config = kept_in(folder);
  Network first(config);
  first.publish(synthetic_camera());
  publish(first, 0, 30);
  first.settle();
  const Life second = live(config, 0, 30);
  EXPECT_EQ(second.last.map_is_safe, 0);
  EXPECT_EQ(second.poses.size(), 30u);
  EXPECT_FALSE(second.keyframes.empty());
}

TEST(StoredMaps, ADamagedOneIsSaidAndLeftAndAnotherBegins) {
  const TemporaryFolder folder;
  const ServerConfig config = kept_in(folder);
  live(config, 0, 40);
  std::vector<std::uint8_t> bytes = read_bytes(file_of(config));
  bytes[bytes.size() / 3] ^= 1;
  test::write_bytes(file_of(config), bytes);
  EXPECT_FALSE(check_map(file_of(config), false).ok);
  const Life after = live(config, 0, 40);
  EXPECT_EQ(after.map_id, 2);
  EXPECT_EQ(read_bytes(file_of(config)), bytes);
  EXPECT_TRUE(std::filesystem::exists(file_of(config, 2)));
  // And with what was whole of it, once somebody has said so.
  const MapCheck repaired = check_map(file_of(config), true);
  EXPECT_TRUE(repaired.ok) << repaired.said;
  EXPECT_EQ(read_bytes(file_of(config).string() + ".damaged"), bytes);
}

TEST(StoredMaps, EachCameraHasItsOwn) {
  const TemporaryFolder folder;
  const ServerConfig config = kept_in(folder);
  {
    Network network(config);
    for (const char* camera : {"a", "b"}) {
      network.publish(synthetic_camera(), camera);
      const SyntheticStream world(*camera);
      for (int i = 0; i < 30; ++i) {
        FeatureFrame frame = world.frame(i);
        frame.camera = camera;
        network.publish(frame);
      }
    }
    network.settle();
  }
  for (const char* camera : {"a", "b"})
    EXPECT_TRUE(
        check_map(std::filesystem::path(config.maps_folder) / camera / "map-1.eifmap", false).ok);
}

}  // namespace
}  // namespace eifmap
