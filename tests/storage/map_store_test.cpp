// A camera's maps in a folder: lost, begun again, merged, and the moments between.
#include "storage/map_store.h"

#include <gtest/gtest.h>

#include "sequence/temporary_folder.h"
#include "storage/mapped_walk.h"
#include "support/file_bytes.h"

namespace eifmap::test {
namespace {

const Camera kCamera = synthetic_camera();

// A map of a world of its own.
MapSnapshot map_of(std::uint64_t world, std::int64_t map_id, std::int64_t epoch, int frames = 30) {
  const SyntheticStream stream(world);
  Mapper mapper(kCamera, {});
  for (int i = 0; i < frames; ++i) mapper.process(stream.view(i, walk_pose(i)));
  MapSnapshot snapshot = *mapper.snapshot().in_use;
  snapshot.map_id = map_id;
  snapshot.epoch = epoch;
  return snapshot;
}

MapStore::Loaded loaded(const std::filesystem::path& folder, const Camera& camera = kCamera) {
  MapStore store(folder);
  EXPECT_EQ(store.open(), "");
  return store.load(camera, {});
}

TEST(MapStore, BeginsEmpty) {
  const TemporaryFolder folder;
  const MapStore::Loaded nothing = loaded(folder.path() / "made");
  EXPECT_FALSE(nothing.snapshot.in_use);
  EXPECT_EQ(nothing.snapshot.last_map_id, 0);
}

TEST(MapStore, KnowsWhichMapWasInUse) {
  const TemporaryFolder folder;
  const MapSnapshot first = map_of(1, 1, 0), second = map_of(2, 2, 1);
  {
    MapStore store(folder.path());
    ASSERT_EQ(store.open(), "");
    ASSERT_EQ(store.save({first, {}, 1}, kCamera, 7), "");
    ASSERT_EQ(store.save({second, {first}, 2}, kCamera, 8), "");
  }
  const MapStore::Loaded both = loaded(folder.path());
  ASSERT_TRUE(both.snapshot.in_use);
  EXPECT_EQ(both.snapshot.in_use->map_id, 2);
  EXPECT_EQ(digest_of(*both.snapshot.in_use), digest_of(second));
  ASSERT_EQ(both.snapshot.kept.size(), 1u);
  EXPECT_EQ(digest_of(both.snapshot.kept[0]), digest_of(first));
  EXPECT_EQ(both.snapshot.last_map_id, 2);
  EXPECT_EQ(both.seq, 8);
}

// The camera came back to the first, where the second had become part of it.
TEST(MapStore, AMapThatIsInAnotherIsGone) {
  const TemporaryFolder folder;
  MapSnapshot first = map_of(1, 1, 0);
  const MapSnapshot second = map_of(2, 2, 1);
  const std::filesystem::path of_second = folder.path() / "map-2.eifmap";
  std::vector<std::uint8_t> bytes;
  {
    MapStore store(folder.path());
    ASSERT_EQ(store.open(), "");
    ASSERT_EQ(store.save({first, {}, 1}, kCamera, 1), "");
    ASSERT_EQ(store.save({second, {first}, 2}, kCamera, 2), "");
    bytes = read_bytes(of_second);
    first.epoch = 2;
    ASSERT_EQ(store.save({first, {}, 2}, kCamera, 3), "");
    EXPECT_FALSE(std::filesystem::exists(of_second));
  }
  // As if it had ended just before it removed the file.
  write_bytes(of_second, bytes);
  const MapStore::Loaded after = loaded(folder.path());
  ASSERT_TRUE(after.snapshot.in_use);
  EXPECT_EQ(after.snapshot.in_use->map_id, 1);
  EXPECT_TRUE(after.snapshot.kept.empty());
  EXPECT_EQ(after.snapshot.last_map_id, 2) << "no id is used twice";
}

TEST(MapStore, WhatIsDamagedIsLeftAndNothingIsThrownAway) {
  const TemporaryFolder folder;
  const MapSnapshot first = map_of(1, 1, 0), second = map_of(2, 2, 1);
  {
    MapStore store(folder.path());
    ASSERT_EQ(store.open(), "");
    ASSERT_EQ(store.save({first, {}, 1}, kCamera, 1), "");
    ASSERT_EQ(store.save({second, {first}, 2}, kCamera, 2), "");
  }
  const std::filesystem::path of_second = folder.path() / "map-2.eifmap";
  std::vector<std::uint8_t> bytes = read_bytes(of_second);
  bytes[bytes.size() / 2] ^= 1;
  write_bytes(of_second, bytes);
  MapStore store(folder.path());
  ASSERT_EQ(store.open(), "");
  const MapStore::Loaded after = store.load(kCamera, {});
  ASSERT_EQ(after.refused.size(), 1u);
  EXPECT_EQ(after.refused[0].reason, Reason::kMapFileDamaged);
  EXPECT_EQ(after.refused[0].file, of_second);
  ASSERT_TRUE(after.snapshot.in_use);
  EXPECT_EQ(after.snapshot.in_use->map_id, 1);
  ASSERT_EQ(store.save({map_of(1, 1, 5, 40), {}, 2}, kCamera, 3), "");
  EXPECT_EQ(read_bytes(of_second), bytes);
}

TEST(MapStore, ARepairedOneIsThereAgain) {
  const TemporaryFolder folder;
  const MapSnapshot first = map_of(1, 1, 0), second = map_of(2, 2, 1);
  const std::filesystem::path of_first = folder.path() / "map-1.eifmap";
  {
    MapStore store(folder.path());
    ASSERT_EQ(store.open(), "");
    ASSERT_EQ(store.save({first, {}, 1, 0}, kCamera, 1), "");
  }
  const std::vector<std::uint8_t> whole = read_bytes(of_first);
  std::vector<std::uint8_t> damaged = whole;
  damaged[damaged.size() / 2] ^= 1;
  write_bytes(of_first, damaged);
  {
    MapStore store(folder.path());
    ASSERT_EQ(store.open(), "");
    ASSERT_EQ(store.load(kCamera, {}).refused.size(), 1u);
    ASSERT_EQ(store.save({second, {}, 2, 0}, kCamera, 2), "");
  }
  write_bytes(of_first, whole);
  MapStore store(folder.path());
  ASSERT_EQ(store.open(), "");
  const MapStore::Loaded after = store.load(kCamera, {});
  ASSERT_TRUE(after.snapshot.in_use);
  EXPECT_EQ(after.snapshot.in_use->map_id, 2);
  ASSERT_EQ(after.snapshot.kept.size(), 1u);
  ASSERT_EQ(store.save(after.snapshot, kCamera, 3), "");
  EXPECT_TRUE(std::filesystem::exists(of_first));
}

TEST(MapStore, MapsOfAnotherCalibrationStay) {
  const TemporaryFolder folder;
  {
    MapStore store(folder.path());
    ASSERT_EQ(store.open(), "");
    ASSERT_EQ(store.save({map_of(1, 1, 0), {}, 1}, kCamera, 1), "");
  }
  Camera other = kCamera;
  other.fx += 1;
  const MapStore::Loaded none = loaded(folder.path(), other);
  EXPECT_FALSE(none.snapshot.in_use);
  EXPECT_EQ(none.snapshot.last_map_id, 1);
  ASSERT_EQ(none.refused.size(), 1u);
  EXPECT_EQ(none.refused[0].reason, Reason::kMapFileOther);
  EXPECT_TRUE(loaded(folder.path()).snapshot.in_use);
}

TEST(MapStore, IsOneServersOwn) {
  const TemporaryFolder folder;
  MapStore store(folder.path());
  ASSERT_EQ(store.open(), "");
  MapStore other(folder.path());
  EXPECT_NE(other.open().find("another server"), std::string::npos);
}

}  // namespace
}  // namespace eifmap::test
