// Maps in files: whole ones, and the rows behind their checksums.
#include "fuzz/target.h"
#include "options.h"
#include "storage/map_file.h"
#include "storage/map_rows.h"
#include "storage/small_map.h"

namespace eifmap::fuzz {
namespace {

Wire small_record() {
  RowBook book;
  put_map(test::small_map(), nullptr, {synthetic_camera(), 1, 1, {}}, book);
  return book.record();
}

Wire small_file() {
  return record_file(11, small_record());
}

void check_map(const MapSnapshot& snapshot) {
  require(snapshot.map->num_keyframes() >= 2, "a map has two keyframes");
}

bool run_file(Bytes bytes) {
  const LoadedMap loaded = load_map(scan_records(Wire(bytes.begin(), bytes.end())), {});
  if (loaded.ok()) check_map(loaded.snapshot);
  return loaded.ok();
}

// Without the digest, which nothing that is changed would pass.
bool run_rows(Bytes bytes) {
  RowSet rows;
  if (!rows.add(bytes).empty()) return false;
  ReadMap read = read_map(rows);
  if (!read.problem.empty() || !problem_of(read.contents).empty()) return false;
  return restore_map(std::move(read.contents), read.head.names.camera, {}) != nullptr;
}

}  // namespace

std::vector<Target> storage_targets() {
  return {{"map_file", &run_file, [] { return std::vector<Wire>{small_file()}; }},
          {"map_rows", &run_rows, [] { return std::vector<Wire>{small_record()}; }}};
}

}  // namespace eifmap::fuzz
