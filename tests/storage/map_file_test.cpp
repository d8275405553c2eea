// Maps in files: what is loaded is what was saved, or nothing.
#include "storage/map_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "map/audit.h"
#include "sequence/temporary_folder.h"
#include "storage/hash.h"
#include "storage/mapped_walk.h"
#include "storage/small_map.h"
#include "support/file_bytes.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

const SyntheticStream kWorld(3);

bool is_long() {
  return std::getenv("EIFMAP_LONG") != nullptr;
}

MapNames names(std::int64_t seq) {
  return {synthetic_camera(), seq, 1, {}};
}

// Maps frames from..to, and calls `on_update` after each that has changed the map.
template <class OnUpdate>
void walk(Mapper& mapper, int from, int to, bool measured, const OnUpdate& on_update) {
  for (int i = from; i < to; ++i) {
    if (measured) mapper.add_measurement(walk_position(i)), mapper.add_measurement(walk_gravity(i));
    if (mapper.process(kWorld.view(i, walk_pose(i))).map_updated) on_update(mapper.snapshot());
  }
}
void walk(Mapper& mapper, int from, int to, bool measured = false) {
  walk(mapper, from, to, measured, [](const MapperSnapshot&) {});
}

void expect_same_map(const Map& saved, const Map& loaded) {
  ASSERT_EQ(saved.num_keyframes(), loaded.num_keyframes());
  ASSERT_EQ(saved.num_tracks(), loaded.num_tracks());
  EXPECT_EQ(saved.num_landmarks(), loaded.num_landmarks());
  EXPECT_EQ(saved.filter().num_edges(), loaded.filter().num_edges());
  EXPECT_EQ(saved.filter().absolutes().size(), loaded.filter().absolutes().size());
  EXPECT_EQ(saved.is_metric(), loaded.is_metric());
  EXPECT_EQ(saved.epoch(), loaded.epoch());
  EXPECT_EQ(saved.places().ready(), loaded.places().ready());
  for (int k = 0; k < saved.num_keyframes(); ++k) {
    EXPECT_EQ(saved.is_removed(k), loaded.is_removed(k));
    EXPECT_EQ(saved.pose(k).translation, loaded.pose(k).translation);
    EXPECT_EQ(saved.pose(k).rotation.coeffs(), loaded.pose(k).rotation.coeffs());
  }
  for (int t = 0; t < saved.num_tracks(); ++t) {
    ASSERT_EQ(saved.track(t).is_landmark(), loaded.track(t).is_landmark());
    ASSERT_EQ(saved.track(t).sights.size(), loaded.track(t).sights.size());
    if (saved.track(t).is_landmark()) {
      EXPECT_EQ(saved.position(t), loaded.position(t));
    }
  }
  EXPECT_EQ(audit(loaded), std::vector<std::string>());
}

// Measurements are all linearized at the mean, where some of the saved map's were near it.
void expect_same_covariances(const Map& saved, const Map& loaded) {
  for (int k = 1; k < saved.num_keyframes(); ++k) {
    PoseBlock was, is;
    if (!saved.filter().pose_covariance(k, was)) continue;
    ASSERT_TRUE(loaded.filter().pose_covariance(k, is));
    EXPECT_LT((is - was).norm(), 0.02 * was.norm()) << "keyframe " << k;
  }
}

LoadedMap saved_and_loaded(const Mapper& mapper, const TemporaryFolder& folder) {
  MapFile file(folder.path() / "map");
  EXPECT_EQ(file.save(*mapper.snapshot().in_use, names(5)), "");
  return load_map(folder.path() / "map", {});
}

TEST(MapFile, GivesBackTheMap) {
  const TemporaryFolder folder;
  Mapper mapper(synthetic_camera(), {});
  walk(mapper, 0, 60);
  const LoadedMap loaded = saved_and_loaded(mapper, folder);
  ASSERT_TRUE(loaded.ok()) << loaded.detail;
  const MapperSnapshot snapshot = mapper.snapshot();
  EXPECT_EQ(loaded.snapshot.map_id, 1);
  EXPECT_EQ(loaded.head.names.seq, 5);
  expect_same_map(*snapshot.in_use->map, *loaded.snapshot.map);
  expect_same_covariances(*snapshot.in_use->map, *loaded.snapshot.map);
  EXPECT_EQ(digest_of(*snapshot.in_use), digest_of(loaded.snapshot));
  EXPECT_GT(loaded.snapshot.map->num_keyframes(), 10);
  EXPECT_TRUE(loaded.snapshot.map->places().ready());
}

TEST(MapFile, GivesBackAMapInMetresAndItsPlaceOnEarth) {
  const TemporaryFolder folder;
  Mapper mapper(synthetic_camera(), {});
  walk(mapper, 0, 60, true);
  ASSERT_EQ(mapper.statistics().earth.status, EarthStatus::kPlaced);
  const LoadedMap loaded = saved_and_loaded(mapper, folder);
  ASSERT_TRUE(loaded.ok()) << loaded.detail;
  const Map& saved = *mapper.snapshot().in_use->map;
  expect_same_map(saved, *loaded.snapshot.map);
  expect_same_covariances(saved, *loaded.snapshot.map);
  EXPECT_GT(saved.filter().absolutes().size(), 5u);
  EXPECT_EQ(loaded.snapshot.map->scale().state.metres_per_unit,
            saved.scale().state.metres_per_unit);
  EXPECT_EQ(loaded.snapshot.map->filter().earth_from_map().translation,
            saved.filter().earth_from_map().translation);
  EXPECT_EQ(digest_of(*mapper.snapshot().in_use), digest_of(loaded.snapshot));
}

TEST(MapFile, GivesBackAMapThatKeyframesWereTakenOutOf) {
  const TemporaryFolder folder;
  MapperOptions options;
  options.bound.max_keyframes = 20;
  options.keyframe.redundant_share = 2;  // none goes for that
  Mapper mapper(synthetic_camera(), options);
  walk(mapper, 0, 100);
  ASSERT_GT(mapper.statistics().removed_keyframes, 0);
  const LoadedMap loaded = saved_and_loaded(mapper, folder);
  ASSERT_TRUE(loaded.ok()) << loaded.detail;
  expect_same_map(*mapper.snapshot().in_use->map, *loaded.snapshot.map);
  EXPECT_EQ(loaded.snapshot.removed_keyframes, mapper.statistics().removed_keyframes);
}

// Lost until an image shows where the camera is; then the map grows, with the same names.
TEST(MapFile, AMapperGoesOnWhereAnotherEnded) {
  const TemporaryFolder folder;
  for (const bool measured : {false, true}) {
    Mapper before(synthetic_camera(), {});
    walk(before, 0, 60, measured);
    MapperSnapshot snapshot;
    LoadedMap loaded = saved_and_loaded(before, folder);
    ASSERT_TRUE(loaded.ok()) << loaded.detail;
    snapshot.in_use = std::move(loaded.snapshot);
    snapshot.last_map_id = 1;

    Mapper after(synthetic_camera(), {});
    after.restore(snapshot);
    EXPECT_THROW(after.restore(snapshot), std::invalid_argument);
    const MapUpdate whole = after.map_update();
    EXPECT_EQ(whole.base_seq, -1);
    EXPECT_EQ(whole.keyframes.size(),
              static_cast<std::size_t>(before.snapshot().in_use->map->num_keyframes()));
    const FrameResult first = after.process(kWorld.view(60, walk_pose(60)));
    EXPECT_EQ(first.state, TrackingState::kTracking);
    EXPECT_EQ(first.source, PoseSource::kRelocalized);
    EXPECT_EQ(first.map_id, 1);
    walk(before, 60, 100, measured);
    walk(after, 61, 100, measured);
    EXPECT_EQ(after.statistics().losses, 0);
    EXPECT_EQ(after.audit(), std::vector<std::string>());
    EXPECT_EQ(after.final_trajectory().size(), 100u);
    // Both are of the same way; the one has a gap of a frame.
    const Rigid3 a = before.final_trajectory().back().world_from_camera,
                 b = after.final_trajectory().back().world_from_camera;
    EXPECT_LT((a.translation - b.translation).norm(), 0.01 * (1 + a.translation.norm()));
  }
}

struct Journal {
  TemporaryFolder folder;
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint64_t> digests;  // of each update's map
  std::vector<std::size_t> sizes;      // of the file after it

  explicit Journal(bool measured) {
    Mapper mapper(synthetic_camera(), {});
    MapFile file(folder.path() / "map");
    walk(mapper, 0, 45, measured, [&](const MapperSnapshot& snapshot) {
      EXPECT_EQ(file.save(*snapshot.in_use, names(1)), "");
      digests.push_back(digest_of(*snapshot.in_use));
      sizes.push_back(file.size());
    });
    bytes = read_bytes(folder.path() / "map");
  }
  bool knows(const LoadedMap& loaded) const {
    return std::find(digests.begin(), digests.end(), digest_of(loaded.snapshot)) != digests.end();
  }
};

TEST(MapFile, GrowsByWhatHasChanged) {
  const Journal journal(true);
  ASSERT_GT(journal.digests.size(), 8u);
  const LoadedMap loaded = load_map(scan_records(journal.bytes), {});
  ASSERT_TRUE(loaded.ok()) << loaded.detail;
  EXPECT_EQ(loaded.records, journal.digests.size());
  EXPECT_EQ(digest_of(loaded.snapshot), journal.digests.back());
  // Not by far as if all of it were written each time.
  MapFile anew(journal.folder.path() / "anew");
  ASSERT_EQ(anew.save(loaded.snapshot, names(1)), "");
  EXPECT_LT(journal.bytes.size(), 4 * anew.size());
}

// What is read of a cut file is the records before: the map is then loaded of these alone.
TEST(MapFile, CutAtAnyByteOfItsLastThreeRecordsItIsTheMapOfBefore) {
  const Journal journal(false);
  const std::size_t n = journal.sizes.size();
  ASSERT_GT(n, 5u);
  const std::size_t stride = is_long() ? 1 : 7;
  for (std::size_t r = n - 3; r < n; ++r) {
    const auto cut = [&](std::size_t size) {
      return scan_records({journal.bytes.begin(), journal.bytes.begin() + static_cast<long>(size)});
    };
    for (std::size_t size = journal.sizes[r - 1]; size < journal.sizes[r]; size += stride) {
      const RecordScan scan = cut(size);
      ASSERT_TRUE(scan.ok()) << "at " << size << ": " << scan.detail;
      ASSERT_EQ(scan.records.size(), r) << "at " << size;
      ASSERT_EQ(scan.torn_bytes, size - journal.sizes[r - 1]);
    }
    const LoadedMap loaded = load_map(cut(journal.sizes[r] - 1), {});
    ASSERT_TRUE(loaded.ok()) << loaded.detail;
    EXPECT_EQ(digest_of(loaded.snapshot), journal.digests[r - 1]);
  }
}

TEST(MapFile, WithBitsChangedItIsRefusedOrOneOfTheMapsThatWere) {
  const Journal journal(true);
  Random random(5);
  int refused = 0;
  const int runs = is_long() ? 1000 : 60;
  for (int i = 0; i < runs; ++i) {
    std::vector<std::uint8_t> bytes = journal.bytes;
    for (std::uint64_t n = 1 + random.bits() % 3; n > 0; --n)
      bytes[random.bits() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random.bits() % 8);
    const LoadedMap loaded = load_map(scan_records(std::move(bytes)), {});
    if (!loaded.ok()) {
      ++refused;
      EXPECT_FALSE(loaded.detail.empty());
      continue;
    }
    EXPECT_TRUE(journal.knows(loaded)) << "run " << i;
  }
  EXPECT_GT(refused, runs / 3);
}

// Rows that are whole, and say what no map can be: the checks behind the checksum.
TEST(MapFile, RowsThatDoNotFitEachOtherAreRefused) {
  Mapper mapper(synthetic_camera(), {});
  walk(mapper, 0, 45, true);
  const MapSnapshot snapshot = *mapper.snapshot().in_use;
  RowBook all;
  put_map(snapshot, nullptr, names(1), all);
  const std::vector<std::uint8_t> record = all.record();
  RowSet whole;
  ASSERT_EQ(whole.add(record), "");
  ASSERT_EQ(read_map(whole).problem, "");
  ASSERT_EQ(problem_of(read_map(whole).contents), "");
  Random random(9);
  int refused = 0;
  constexpr int kRuns = 300;
  for (int i = 0; i < kRuns; ++i) {
    // Behind the digest: what it guards against is not looked at here.
    std::vector<std::uint8_t> bytes = record;
    for (std::uint64_t n = 1 + random.bits() % 8; n > 0; --n)
      bytes[8 + random.bits() % (bytes.size() - 8)] = static_cast<std::uint8_t>(random.bits());
    RowSet rows;
    if (!rows.add(bytes).empty()) {
      ++refused;
      continue;
    }
    ReadMap read = read_map(rows);
    if (!read.problem.empty() || !problem_of(read.contents).empty()) {
      ++refused;
      continue;
    }
    restore_map(std::move(read.contents), read.head.names.camera, {});  // never throws
  }
  EXPECT_GT(refused, 3);
}

// A camera that never rests makes ten thousand tracks a minute, of which a bounded map has few
// left.
TEST(MapFile, TracksThatAreNoMoreAreNoBurden) {
  const TemporaryFolder folder;
  MapSnapshot snapshot = small_map();
  Map map = *snapshot.map;
  for (int n = 0; n < 1'000'000; ++n) map.remove_track(map.add_track({0, 3}));
  const int last = map.add_track({0, 3});
  snapshot.map = std::make_shared<Map>(std::move(map));
  MapFile file(folder.path() / "map");
  ASSERT_EQ(file.save(snapshot, names(1)), "");
  EXPECT_LT(file.size(), 20'000u);
  const LoadedMap loaded = load_map(file.file(), {});
  ASSERT_TRUE(loaded.ok()) << loaded.detail;
  const Map& read = *loaded.snapshot.map;
  EXPECT_EQ(read.num_tracks(), last + 1);
  ASSERT_EQ(read.track(last).sights.size(), 1u);
  EXPECT_EQ(read.track(last).sights.front().keypoint, 3);
  EXPECT_EQ(read.tracks().num_pieces_held(), 2u);
}

// Files of every version so far are in version_N.eifmap. Who makes another one adds its file, which
// EIFMAP_WRITE_VERSION names, and never changes those that are there.
TEST(MapFile, OfEveryVersionSoFarIsRead) {
  if (const char* file = std::getenv("EIFMAP_WRITE_VERSION")) {
    ASSERT_EQ(MapFile(file).save(small_map(), names(3)), "");
  }
  for (std::uint32_t version = 1; version <= kFileVersion; ++version) {
    const std::filesystem::path file = std::filesystem::path(EIFMAP_MAP_VERSIONS) /
                                       ("version_" + std::to_string(version) + ".eifmap");
    const LoadedMap loaded = load_map(file, {});
    ASSERT_TRUE(loaded.ok()) << file << ": " << loaded.detail;
    EXPECT_EQ(loaded.head.names.seq, 3);
    EXPECT_EQ(loaded.snapshot.map->num_keyframes(), 3);
    EXPECT_EQ(loaded.snapshot.map->num_tracks(), 9);
    EXPECT_EQ(loaded.snapshot.map->num_landmarks(), 8);
    EXPECT_NEAR(loaded.snapshot.map->pose(2).translation.x(), 1, 1e-3);
    EXPECT_EQ(audit(*loaded.snapshot.map), std::vector<std::string>());
  }
}

TEST(MapFile, OfALaterVersionIsRefused) {
  const TemporaryFolder folder;
  MapFile file(folder.path() / "map");
  ASSERT_EQ(file.save(small_map(), names(1)), "");
  std::vector<std::uint8_t> bytes = read_bytes(folder.path() / "map");
  bytes[8] = kFileVersion + 1;
  const std::uint64_t hash = hash_bytes(std::span(bytes).first(24), 0);
  std::memcpy(bytes.data() + 24, &hash, sizeof hash);
  const LoadedMap loaded = load_map(scan_records(std::move(bytes)), {});
  EXPECT_EQ(loaded.reason, Reason::kMapFileNewer) << loaded.detail;
}

TEST(MapFile, OfAnotherCalibrationIsRefused) {
  const TemporaryFolder folder;
  Mapper mapper(synthetic_camera(), {});
  walk(mapper, 0, 45);
  MapFile file(folder.path() / "map");
  ASSERT_EQ(file.save(*mapper.snapshot().in_use, names(1)), "");
  Camera other = synthetic_camera();
  other.fx += 1;
  EXPECT_EQ(load_map(folder.path() / "map", {}, &other).reason, Reason::kMapFileOther);
  const Camera same = synthetic_camera();
  EXPECT_TRUE(load_map(folder.path() / "map", {}, &same).ok());
}

}  // namespace
}  // namespace eifmap::test
