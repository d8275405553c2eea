// One map in one file, which grows by what each keyframe has changed and is written anew when most
// of it is old: journal and map file are one format (record_file.h, rows.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "map/map_snapshot.h"
#include "options.h"
#include "storage/map_fields.h"
#include "storage/record_file.h"
#include "storage/rows.h"

namespace eifmap {

class MapFile {
 public:
  // What may be at this place is left alone until the first save(), which replaces it.
  explicit MapFile(std::filesystem::path file) : file_(std::move(file)) {}

  // Returns when the map is on the disk: "" or what went wrong, and then the file says what it said
  // before, and the next call saves what this one did not.
  std::string save(const MapSnapshot& now, const MapNames& names);

  // Of the map saved last; null before.
  const MapSnapshot* saved() const { return saved_ ? &*saved_ : nullptr; }
  const std::filesystem::path& file() const { return file_; }
  std::uint64_t size() const { return writer_.size(); }

 private:
  std::string replace(const MapSnapshot& now, const MapNames& names);
  bool is_worth_replacing() const;

  std::filesystem::path file_;
  RecordWriter writer_;
  RowBook book_;
  std::optional<MapSnapshot> saved_;
  std::uint64_t size_when_new_ = 0;
};

struct LoadedMap {
  // kNone: there is a map. kMapFileUnreadable, kMapFileUnknown, kMapFileNewer, kMapFileDamaged, or
  // kMapFileOther: of another calibration than the one asked for.
  Reason reason = Reason::kNone;
  std::string detail;
  MapHead head;
  MapSnapshot snapshot;
  std::size_t records = 0, whole_bytes = 0;
  std::size_t torn_bytes = 0;  // after them: what was being written when the writer ended

  bool ok() const { return reason == Reason::kNone; }
};

// Never throws on what a file may hold. `camera`: the one that its map must be of; null: any.
LoadedMap load_map(const std::filesystem::path& file, const MapperOptions& options,
                   const Camera* camera = nullptr);
LoadedMap load_map(RecordScan scan, const MapperOptions& options, const Camera* camera = nullptr);

}  // namespace eifmap
