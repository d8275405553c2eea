// The server's figures, and the status message made of them.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <eifmap/status_t.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "convert/feature_parts.h"
#include "map_view.h"
#include "server/command_desk.h"
#include "server/diagnostics.h"
#include "server/map_publisher.h"
#include "server/map_saver.h"
#include "server/measurement_intake.h"
#include "server/stream_book.h"

namespace eifmap {

class StatusBoard {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  explicit StatusBoard(std::int64_t server_epoch);

  void note_frame(const FrameResult& result, TimePoint received, TimePoint published);
  // Of a calibration, refused or changed.
  void note_reason(Reason reason, const std::string& detail);
  // Of a measurement, or of a request, that was refused.
  void note_measurement(Reason reason, const std::string& detail);
  // An exception that should not be: `detail` says which.
  void note_fault(const std::string& detail);
  void note_new_map();  // the mapper begins again
  void note_stopping() { stopping_ = true; }
  // Mapping goes on with a map of before.
  void note_resumed(std::int64_t map_id, const MapperStatistics& statistics);
  // What of the maps is on the disk: true when that is another word than before.
  bool note_saved(const MapSaver::State& saved);
  // By command: until it is false again, no frame is mapped, and each is told of.
  void set_paused(bool paused) { paused_ = paused; }
  bool is_paused() const { return paused_; }
  void note_paused_frame() { ++paused_frames_; }
  std::int64_t paused_frames() const { return paused_frames_; }
  void note_part_sent() { ++parts_sent_; }
  // What of the map was not sent in time, at the end.
  void note_parts_left(std::int64_t parts);
  void note_send_failure() { ++send_failures_; }

  // Figures that others count.
  struct Counts {
    std::int64_t frames_received = 0, frames_dropped = 0, foreign_frames = 0, bad_channels = 0;
    bool calibration_is_guessed = false;
    FeatureAssembler::Counts parts;
    MeasurementIntake::Counts measurements;
    std::int64_t measurements_dropped = 0;
    std::int64_t map_seq = 0, map_digest = 0;  // of the published map
    MapPublisher::Counts maps = {};
    CommandDesk::Counts commands = {};
  };
  // Rates are over the time since the last call with `new_period`.
  status_t make(const std::string& camera, const Counts& counts, const StreamBook& streams,
                const MapperStatistics& statistics, TimePoint now, bool new_period);

  // What, when it changes, is worth a status at once.
  using Headline = std::pair<std::int8_t, Reason>;  // STATE_*
  Headline headline() const { return {state(), last_.reason}; }

 private:
  std::int8_t state() const;
  void describe_state(status_t& status, const std::string& camera) const;
  void describe_map(status_t& status, const Counts& counts,
                    const MapperStatistics& statistics) const;
  void describe_traffic(status_t& status, const Counts& counts, const StreamBook& streams) const;
  void describe_last_frame(status_t& status) const;
  void describe_own(const Counts& counts, Diagnostics& out) const;
  void measure_rates(std::int64_t received, TimePoint now);
  float latency_ms(double quantile) const;

  status_t identity_;  // what never changes
  FrameResult last_;   // the last frame's; its state is the mapper's last
  std::int64_t processed_ = 0, rejected_ = 0, malformed_ = 0, parts_sent_ = 0, send_failures_ = 0,
               faults_ = 0, parts_left_ = 0, paused_frames_ = 0;
  std::map<Reason, std::int64_t> rejections_;  // frames
  std::vector<float> latencies_ms_;            // a ring
  std::size_t next_latency_ = 0;
  TimePoint period_begin_;
  std::int64_t period_received_ = 0, period_processed_ = 0;
  float input_hz_ = 0, pose_hz_ = 0;
  std::optional<MapSaver::State> saved_;  // none: maps are not kept on the disk
  std::string resumed_;                   // with which map, until a frame comes
  bool stopping_ = false, paused_ = false;
};

}  // namespace eifmap
