#include "storage/map_file.h"

#include <utility>

#include "storage/hash.h"
#include "storage/map_rows.h"

namespace eifmap {

// A file is written anew once more than half of it is old, but not for every few megabytes.
bool MapFile::is_worth_replacing() const {
  constexpr std::uint64_t kLittle = 32u << 20;
  return writer_.size() > 2 * size_when_new_ + kLittle;
}

std::string MapFile::replace(const MapSnapshot& now, const MapNames& names) {
  RowBook book;
  put_map(now, nullptr, names, book);
  const std::vector<std::uint8_t> record = book.record();
  const std::string problem = writer_.replace(file_, hash_bytes(record, 0), record);
  if (!problem.empty()) return problem;
  book.keep();
  book_ = std::move(book);
  size_when_new_ = writer_.size();
  saved_ = now;
  return "";
}

std::string MapFile::save(const MapSnapshot& now, const MapNames& names) {
  if (!writer_.is_open() || !saved_ || is_worth_replacing()) return replace(now, names);
  put_map(now, &*saved_, names, book_);
  if (!book_.has_changes()) return "";
  std::string problem = writer_.append(book_.record());
  if (!problem.empty()) {
    book_.drop();
    return problem;
  }
  book_.keep();
  saved_ = now;
  return "";
}

namespace {

LoadedMap refuse(LoadedMap loaded, Reason reason, std::string detail) {
  loaded.reason = reason;
  loaded.detail = std::move(detail);
  loaded.snapshot = {};
  return loaded;
}

}  // namespace

LoadedMap load_map(RecordScan scan, const MapperOptions& options, const Camera* camera) {
  LoadedMap loaded;
  loaded.records = scan.records.size();
  loaded.whole_bytes = scan.whole_bytes;
  loaded.torn_bytes = scan.torn_bytes;
  if (!scan.ok()) return refuse(std::move(loaded), scan.reason, std::move(scan.detail));
  RowSet rows;
  for (const RowBytes record : scan.records)
    if (std::string problem = rows.add(record); !problem.empty())
      return refuse(std::move(loaded), Reason::kMapFileDamaged, std::move(problem));
  if (std::string problem = rows.problem(); !problem.empty())
    return refuse(std::move(loaded), Reason::kMapFileDamaged, std::move(problem));
  ReadMap read = read_map(rows);
  if (read.problem.empty()) read.problem = problem_of(read.contents);
  if (!read.problem.empty())
    return refuse(std::move(loaded), Reason::kMapFileDamaged, std::move(read.problem));
  loaded.head = read.head;
  if (camera && camera->id() != read.head.names.camera.id())
    return refuse(std::move(loaded), Reason::kMapFileOther,
                  "it is of calibration " + std::to_string(read.head.names.camera.id()) +
                      ", the camera has " + std::to_string(camera->id()));
  loaded.snapshot.map = restore_map(std::move(read.contents), read.head.names.camera, options);
  if (!loaded.snapshot.map)
    return refuse(std::move(loaded), Reason::kMapFileDamaged, "its measurements make no map");
  loaded.snapshot.map_id = read.head.map_id;
  loaded.snapshot.epoch = read.head.epoch;
  loaded.snapshot.log = std::move(read.log);
  loaded.snapshot.most_tracked = std::move(read.most_tracked);
  loaded.snapshot.removed_keyframes = read.head.removed_keyframes;
  loaded.snapshot.removed_landmarks = read.head.removed_landmarks;
  loaded.snapshot.reference = read.head.reference;
  return loaded;
}

LoadedMap load_map(const std::filesystem::path& file, const MapperOptions& options,
                   const Camera* camera) {
  return load_map(scan_records(file), options, camera);
}

}  // namespace eifmap
