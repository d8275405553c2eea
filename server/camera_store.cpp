// A camera's maps on the disk: CameraMapper's part of it.
#include <algorithm>
#include <utility>

#include "server/camera_mapper.h"

namespace eifmap {

// What a mapper of this calibration begins with. Ids go on after all that were published or saved.
MapperSnapshot CameraMapper::stored_maps(const Camera& calibration, bool stored) {
  MapperSnapshot begin;
  if (!config_.maps_folder.empty() && !saver_ && saver_problem_.empty()) {
    saver_.emplace(std::filesystem::path(config_.maps_folder) / camera_);
    saver_problem_ = saver_->open();
    if (!saver_problem_.empty()) {
      saver_.reset();
      refused_files_.push_back({Reason::kMapNotSaved, saver_problem_});
    }
  }
  if (saver_ && stored) {
    saver_->wait_until_idle();
    MapStore::Loaded loaded = saver_->load(calibration, config_.mapper);
    for (const MapStore::Refused& file : loaded.refused)
      refused_files_.push_back({file.reason, file.file.string() + ": " + file.detail});
    map_seq_ = std::max(map_seq_, loaded.seq);
    begin = std::move(loaded.snapshot);
  }
  begin.last_map_id = std::max(begin.last_map_id, largest_map_id_);
  begin.next_epoch = largest_epoch_ + 1;
  if (begin.in_use && localize_only_) safe_seq_ = map_seq_ + 1;  // the update that tells of it
  if (begin.in_use) begin.in_use->epoch = std::max(begin.in_use->epoch, begin.next_epoch);
  return begin;
}

std::optional<MapUpdate> CameraMapper::resume() {
  if (config_.maps_folder.empty() || mapper_ || camera_.empty()) return std::nullopt;
  const Camera* calibration = calibrations_.of(camera_);
  if (!calibration) return std::nullopt;
  begin_map(camera_, *calibration);
  if (mapper_->statistics().keyframes > 0) return next_update();
  return std::nullopt;
}

std::filesystem::path CameraMapper::saved_file(const std::string& name, Taken& problem) const {
  constexpr std::size_t kLongest = 64;
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  };
  if (config_.maps_folder.empty())
    problem = {Reason::kUnsupported, "no folder for maps is given: start the server with --maps"};
  else if (name.empty() || name.size() > kLongest ||
           !std::all_of(name.begin(), name.end(), is_plain))
    problem = {Reason::kBadArguments, "name is '" + name.substr(0, kLongest) +
                                          "', wanted 1 to 64 letters, digits, '-' or '_'"};
  return std::filesystem::path(config_.maps_folder) / camera_ / "saved" / (name + ".eifmap");
}

Taken CameraMapper::save_map(const std::string& name) {
  Taken taken;
  const std::filesystem::path file = saved_file(name, taken);
  if (taken.reason != Reason::kNone) return taken;
  const MapperSnapshot snapshot = mapper_ ? mapper_->snapshot() : MapperSnapshot();
  if (!snapshot.in_use) return {Reason::kNoMap, ""};
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error) return {Reason::kMapNotSaved, file.parent_path().string() + ": " + error.message()};
  std::string problem = MapFile(file).save(
      *snapshot.in_use, {*calibrations_.of(camera_), map_seq_, snapshot.last_map_id, {}});
  if (!problem.empty()) return {Reason::kMapNotSaved, std::move(problem)};
  return {Reason::kNone, file.string()};
}

Taken CameraMapper::load_map(const std::string& name) {
  Taken taken;
  const std::filesystem::path file = saved_file(name, taken);
  if (taken.reason != Reason::kNone) return taken;
  const Camera* calibration = calibrations_.of(camera_);
  if (!calibration) return {Reason::kNoCalibration, "camera " + camera_};
  LoadedMap loaded = eifmap::load_map(file, config_.mapper, calibration);
  if (!loaded.ok()) return {loaded.reason, file.string() + ": " + loaded.detail};
  begin_map(camera_, *calibration, false);
  MapperSnapshot begin = mapper_->snapshot();
  loaded.snapshot.map_id = ++begin.last_map_id;  // a number says one map
  loaded.snapshot.epoch = largest_epoch_ + 1;
  begin.in_use = std::move(loaded.snapshot);
  mapper_->restore(begin);
  was_reset_ = true;
  commanded_ = next_update();
  return {Reason::kNone, file.string()};
}

void CameraMapper::localize_only(bool only) {
  const bool begins = only && !localizes_only();
  localize_only_ = only;
  if (mapper_) mapper_->localize_only(only);
  if (begins && mapper_) commanded_ = settle(IfItFails::kGiveUpMap);
}

void CameraMapper::save_maps() {
  if (saver_ && mapper_ && map_seq_ > safe_seq_)
    saver_->save(mapper_->snapshot(), *calibrations_.of(camera_), map_seq_);
}

std::optional<MapSaver::State> CameraMapper::saved() const {
  if (config_.maps_folder.empty() || !mapper_) return std::nullopt;
  MapSaver::State state;
  if (saver_) {
    state = saver_->state();
    state.seq = std::max(state.seq, safe_seq_);
    return state;
  }
  state.seq = map_seq_;
  state.is_safe = false;
  state.problem = saver_problem_;
  return state;
}

void CameraMapper::wait_until_saved() {
  if (saver_) saver_->wait_until_idle();
}

}  // namespace eifmap
