// Saves a camera's maps in a thread of its own: no pose waits for the disk. What the disk has is
// told by update, so that none is published before what it acknowledges is safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "geometry/camera.h"
#include "map/map_snapshot.h"
#include "storage/map_store.h"

namespace eifmap {

class MapSaver {
 public:
  // The camera's own folder. Nothing is read or written yet.
  explicit MapSaver(std::filesystem::path folder) : store_(std::move(folder)) {}
  ~MapSaver();  // when what waits is saved, or has failed once more
  MapSaver(const MapSaver&) = delete;
  MapSaver& operator=(const MapSaver&) = delete;

  // Both once, before the first save(): "" or what is wrong, and the maps of this calibration.
  std::string open() { return store_.open(); }
  MapStore::Loaded load(const Camera& camera, const MapperOptions& options) {
    return store_.load(camera, options);
  }

  // The maps as of this update. One that still waits is not saved any more: this one has all of it.
  void save(MapperSnapshot snapshot, const Camera& camera, std::int64_t seq);

  struct State {
    std::int64_t seq = 0;                  // of the update that was dealt with last
    bool is_safe = true;                   // it is on the disk
    std::string problem;                   // why not, in words
    std::int64_t saved = 0, failures = 0;  // calls, of those that were not overtaken
  };
  State state() const;
  void wait_until_idle();

 private:
  struct Job {
    MapperSnapshot snapshot;
    Camera camera;
    std::int64_t seq = 0;
  };
  void run();

  MapStore store_;  // the thread's, once it runs
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Job> waiting_;
  State state_;
  bool works_ = false, closing_ = false;
  std::thread thread_;
};

}  // namespace eifmap
