// One camera's mapping as its messages come in: calibrations, images or feature frames. Knows no
// network, no thread but that of the keyframes, and no clock but the step timer's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "convert/image_message.h"
#include "convert/relative_message.h"
#include "features/extractor.h"
#include "mapper.h"
#include "server/calibration_book.h"
#include "server/config.h"
#include "server/keyframe_worker.h"
#include "server/map_saver.h"
#include "server/measurement_intake.h"
#include "server/run_record.h"
#include "server/step_timer.h"
#include "server/stream_book.h"
#include "server/taken.h"
#include "wire/bytes.h"
#include "wire/channel.h"

namespace eifmap {

class CameraMapper {
 public:
  // Keeps a copy of the configuration. Throws std::invalid_argument with config.problem().
  explicit CameraMapper(const ServerConfig& config);
  // With another handover than that of a live server.
  CameraMapper(const ServerConfig& config, Handover handover);
  CameraMapper(const CameraMapper&) = delete;
  CameraMapper& operator=(const CameraMapper&) = delete;

  // A calibration message of this camera: CalibrationBook::take(). While the camera is being
  // mapped, another one than that in use waits for the first frame that belongs to it.
  Taken take_calibration(const std::string& camera, Bytes bytes) {
    return calibrations_.take(camera, bytes, mapper_ && camera == camera_);
  }

  // An absolute measurement of this camera: the mapper is given it before its next frame.
  Taken take_measurement(const std::string& camera, Bytes bytes) {
    return measurements_.take(camera, bytes);
  }
  MeasurementIntake::Counts measurements() const { return measurements_.counts(); }

  // Where a keyframe is seen from another one of the map in use; kKeyframeUnknown where one is not
  // in it. Who sends it adds time and origin.
  RelativeAnswer answer(const RelativeRequest& request) const;

  // Of a camera whose maps are kept on the disk: once its calibration is known, and before its
  // first frame, the maps that there are. The whole of the one in use, to be published; nothing
  // where there is none, or it has begun.
  std::optional<MapUpdate> resume();
  // Files that are left as they are, and why; since the last call.
  std::vector<Taken> take_refused_files() { return std::exchange(refused_files_, {}); }
  // After an update has been published, or is about to: saves the maps as they are, in another
  // thread. Then, what has been dealt with, by the update's number; nothing where no folder is
  // given.
  void save_maps();
  std::optional<MapSaver::State> saved() const;
  void wait_until_saved();

  // The map in use, by a name of the user's: letters, digits, '-' and '_', 1 to 64. save_map()
  // returns when it is on the disk; load_map() goes on with that one, under another number, and
  // gives up all that there are. With a reason nothing has changed: kUnsupported where no folder is
  // given, kBadArguments, kNoMap, kMapNotSaved, or what load_map() of storage/map_file.h says.
  Taken save_map(const std::string& name);
  Taken load_map(const std::string& name);
  // Once it is on no map changes: a keyframe that is under way has come into it before this
  // returns. Throws what its job threw; then another map begins, as where a frame meets that.
  void localize_only(bool only);
  // What the last of these did to the map, to be published before the next of them.
  std::optional<MapUpdate> take_commanded() { return std::exchange(commanded_, std::nullopt); }
  bool localizes_only() const { return mapper_ ? mapper_->localizes_only() : localize_only_; }

  struct Mapped {
    FrameResult result;               // rejected, with the reason, when it never reached the map
    std::optional<MapUpdate> update;  // when the frame changed the map
    // When the frame is the first of another calibration, and so of a new map: that, in words.
    std::string new_calibration;
  };
  // An image or a feature frame: channel.kind says which. Unless the configuration names the
  // camera, the first good frame of a calibrated one decides; from then on frames of other cameras
  // must not be given.
  // `received_us`: the server's clock at its reception, for the book of streams alone; 0 unknown.
  Mapped take_frame(const Channel& channel, Bytes bytes, std::int64_t received_us = 0);

  // A keyframe's job that is done needs no frame to be adopted where timing decides; nothing when
  // none is. With `wait`, at the end: any, and one that still runs too.
  std::optional<MapUpdate> adopt_keyframe(bool wait);
  bool maps_beside() const;  // a job runs, or waits for adopt_keyframe()

  // Gives up all maps: the next frame begins another, as if it were the first, and results are of
  // what comes from then on. False where nothing was mapped yet.
  bool reset();

  // Says what the map's unit is: as a distance of two of its keyframes, which enters the map as
  // every absolute measurement does, with the next keyframe, and is replayed as one.
  struct SaidScale {
    Reason reason = Reason::kNone;
    std::string detail;
    NamedMeasurement measurement = {};  // that was taken, where there is no reason against it
  };
  // `sigma`: relative; `id`: one that no other measurement has.
  SaidScale say_scale(double metres_per_unit, double sigma, MeasurementId id);

  // Frames that the server itself dropped before the next one are no gap in their numbers.
  void note_dropped(std::int64_t frames) { dropped_ += frames; }

  // Also told of the mapper's steps; see Mapper. What it throws at a step's begin is a fault there.
  void set_step_observer(std::function<void(std::string_view, bool)> observer) {
    step_observer_ = std::move(observer);
  }

  std::int64_t map_id() const { return map_id_; }  // published last; 0 none
  std::int64_t map_epoch() const { return map_epoch_; }
  // Of maps kept beside the one in use, as they were published.
  std::vector<std::int64_t> kept_maps() const;

  const std::string& camera() const { return camera_; }  // that is mapped; "" none yet
  MapperStatistics statistics() const;
  const StreamBook& streams() const { return streams_; }
  // Of the camera that is mapped: guessed from hfov_deg, and not replaced by a message since.
  bool calibration_is_guessed() const { return calibrations_.is_guessed(camera_); }

  // Before the first frame: write_results() will not be asked for.
  void keep_no_results() { results_ = Results::kNone; }
  bool has_results() const { return record_.has_value(); }
  // Writes what RunRecord writes, of all frames since the calibration last changed. Returns "" or
  // what went wrong.
  std::string write_results(const std::filesystem::path& folder) const;

 private:
  void change_calibration(const std::string& camera);
  Decoded<FeatureFrame> read_frame(const Channel& channel, Bytes bytes);
  Decoded<FeatureFrame> read_image(const Channel& channel, Bytes bytes);
  bool is_late(const ImageMessage& image, const Channel& channel, const Camera& camera) const;
  void map(const FeatureFrame& frame, Mapped& mapped);
  void give_up_map();
  // Waits for the keyframe's job that is under way, if any. Throws what that threw.
  enum class IfItFails { kGiveUpMap, kKeepMap };
  std::optional<MapUpdate> settle(IfItFails then);
  void give_measurements();
  MapUpdate next_update();
  void note_published(std::int64_t map_id, std::int64_t epoch);
  // `stored`: with the maps on the disk, if any; else they are given up, once there is another.
  void begin_map(const std::string& camera, const Camera& calibration, bool stored = true);
  MapperSnapshot stored_maps(const Camera& calibration, bool stored);
  std::filesystem::path saved_file(const std::string& name, Taken& problem) const;
  void note_arrival(std::int64_t publisher, std::int64_t seq, std::int64_t time_us);

  const ServerConfig config_;
  FeatureExtractor extractor_;
  CalibrationBook calibrations_;
  std::string camera_;
  std::optional<KeyframeWorker> keyframes_;  // none: the mapper does it at once
  std::optional<Mapper> mapper_;
  std::optional<MapSaver> saver_;
  std::string saver_problem_;  // why there is none, although a folder is given
  std::vector<Taken> refused_files_;
  std::int64_t safe_seq_ = 0;  // of an update that the disk had already
  std::optional<MapUpdate> commanded_;
  bool localize_only_ = false;
  std::int64_t largest_map_id_ = 0, largest_epoch_ = -1;  // published so far
  // Published last. Updates are numbered through all maps.
  std::int64_t map_id_ = 0, map_epoch_ = 0, map_seq_ = 0;
  StreamBook streams_;
  MeasurementIntake measurements_;
  std::int64_t received_us_ = 0, dropped_ = 0;  // of the frame in work, before it
  bool was_reset_ = false;                      // since the last frame that was taken
  Results results_ = Results::kKept;
  std::optional<RunRecord> record_;
  StepTimer timer_;
  std::function<void(std::string_view, bool)> step_observer_;
};

}  // namespace eifmap
