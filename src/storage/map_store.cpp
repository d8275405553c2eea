#include "storage/map_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

namespace eifmap {
namespace {

constexpr std::string_view kPrefix = "map-", kSuffix = ".eifmap";

std::optional<std::int64_t> id_in(const std::string& file_name) {
  if (file_name.size() <= kPrefix.size() + kSuffix.size() || !file_name.starts_with(kPrefix) ||
      !file_name.ends_with(kSuffix))
    return std::nullopt;
  const char* begin = file_name.data() + kPrefix.size();
  const char* end = file_name.data() + file_name.size() - kSuffix.size();
  std::int64_t id = 0;
  const auto parsed = std::from_chars(begin, end, id);
  if (parsed.ec != std::errc() || parsed.ptr != end || id <= 0) return std::nullopt;
  return id;
}

// By id.
std::map<std::int64_t, std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::map<std::int64_t, std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (const auto id = id_in(entry->path().filename().string())) files[*id] = entry->path();
  return files;
}

}  // namespace

MapStore::~MapStore() {
  if (lock_ >= 0) ::close(lock_);
}

std::string MapStore::open() {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) return "cannot make the folder " + folder_.string() + ": " + error.message();
  const std::filesystem::path file = folder_ / "lock";
  lock_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR | S_IRGRP);
  if (lock_ < 0) return "cannot write to " + folder_.string() + ": " + std::strerror(errno);
  if (::flock(lock_, LOCK_EX | LOCK_NB) == 0) return "";
  ::close(std::exchange(lock_, -1));
  return "the maps in " + folder_.string() +
         " are in use by another server: stop it, or name another folder";
}

std::filesystem::path MapStore::file_of(std::int64_t map_id) const {
  return folder_ / (std::string(kPrefix) + std::to_string(map_id) + std::string(kSuffix));
}

MapFile& MapStore::open_file(std::int64_t map_id) {
  return files_.try_emplace(map_id, file_of(map_id)).first->second;
}

MapStore::Loaded MapStore::load(const Camera& camera, const MapperOptions& options) {
  files_.clear();  // those of another calibration stay
  left_alone_.clear();
  Loaded loaded;
  std::vector<LoadedMap> maps;
  bool all_whole = true;
  for (const auto& [id, file] : files_in(folder_)) {
    last_map_id_ = std::max(last_map_id_, id);
    LoadedMap map = load_map(file, options, &camera);
    last_map_id_ = std::max(last_map_id_, map.head.names.last_map_id);
    loaded.torn_bytes += map.torn_bytes;
    if (!map.ok() || map.head.map_id != id) {
      all_whole = all_whole && map.reason == Reason::kMapFileOther;
      left_alone_.push_back(id);
      loaded.refused.push_back({file, map.ok() ? Reason::kMapFileDamaged : map.reason,
                                map.ok() ? "it is of another map than its name says" : map.detail});
      continue;
    }
    maps.push_back(std::move(map));
  }
  loaded.snapshot.last_map_id = last_map_id_;
  if (maps.empty()) return loaded;
  std::sort(maps.begin(), maps.end(), [](const LoadedMap& a, const LoadedMap& b) {
    return a.head.epoch != b.head.epoch ? a.head.epoch < b.head.epoch
                                        : a.head.map_id < b.head.map_id;
  });
  LoadedMap in_use = std::move(maps.back());
  maps.pop_back();
  loaded.seq = in_use.head.names.seq;
  // Ended between saving the map that two became and removing the other: that is in it already.
  // Where a file is missing, who knows which of them is the last word.
  const std::vector<std::int64_t>& beside = in_use.head.names.beside;
  for (LoadedMap& map : maps)
    if (!all_whole || std::find(beside.begin(), beside.end(), map.head.map_id) != beside.end())
      loaded.snapshot.kept.push_back(std::move(map.snapshot));
    else
      open_file(map.head.map_id);  // to be removed with the next save
  loaded.snapshot.in_use = std::move(in_use.snapshot);
  return loaded;
}

std::string MapStore::save(const MapperSnapshot& snapshot, const Camera& camera, std::int64_t seq) {
  if (!snapshot.in_use) return "";
  MapNames names;
  names.camera = camera;
  names.seq = seq;
  names.last_map_id = std::max(last_map_id_, snapshot.last_map_id);
  for (const MapSnapshot& kept : snapshot.kept) names.beside.push_back(kept.map_id);
  // Somebody may repair one: it is no part of the map in use, and must not go for it then.
  names.beside.insert(names.beside.end(), left_alone_.begin(), left_alone_.end());
  for (const MapSnapshot& kept : snapshot.kept) {
    MapFile& file = open_file(kept.map_id);
    if (file.saved() && file.saved()->map == kept.map &&
        file.saved()->log.size() == kept.log.size())
      continue;
    if (std::string problem = file.save(kept, names); !problem.empty()) return problem;
  }
  const MapSnapshot& in_use = *snapshot.in_use;
  if (std::string problem = open_file(in_use.map_id).save(in_use, names); !problem.empty())
    return problem;
  std::erase_if(files_, [&](const auto& entry) {
    const std::int64_t id = entry.first;
    if (id == in_use.map_id ||
        std::find(names.beside.begin(), names.beside.end(), id) != names.beside.end())
      return false;
    std::error_code error;
    std::filesystem::remove(entry.second.file(), error);
    return true;
  });
  return "";
}

}  // namespace eifmap
