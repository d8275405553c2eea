// All maps of one camera in a folder of its own, map-ID.eifmap each: what is saved is there after a
// restart, whenever that was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "storage/map_file.h"

namespace eifmap {

class MapStore {
 public:
  explicit MapStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~MapStore();
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  // Makes the folder, and has it for itself until it is destroyed, whatever other processes want.
  // "" or what is wrong.
  std::string open();

  struct Refused {
    std::filesystem::path file;
    Reason reason = Reason::kNone;
    std::string detail;
  };
  struct Loaded {
    MapperSnapshot snapshot;  // without a map in use: there is none of this camera
    std::int64_t seq = 0;     // of the last update that was saved
    std::vector<Refused> refused;
    std::size_t torn_bytes = 0;
  };
  // The maps of this calibration. Files that cannot be read, and those of other calibrations, are
  // left as they are; ids go on after theirs.
  Loaded load(const Camera& camera, const MapperOptions& options);

  // Returns when all of it is on the disk. The map in use goes last: with it the others of the
  // snapshot become those that there are. "" or what went wrong, and then what was saved before
  // stays.
  std::string save(const MapperSnapshot& snapshot, const Camera& camera, std::int64_t seq);

 private:
  std::filesystem::path file_of(std::int64_t map_id) const;
  MapFile& open_file(std::int64_t map_id);

  std::filesystem::path folder_;
  int lock_ = -1;
  std::int64_t last_map_id_ = 0;
  std::map<std::int64_t, MapFile> files_;  // of the maps that there are, by id
  std::vector<std::int64_t> left_alone_;   // maps whose files could not be used, as they are
};

}  // namespace eifmap
