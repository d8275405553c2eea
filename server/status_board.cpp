#include "server/status_board.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <fstream>

#include "convert/earth_fields.h"
#include "convert/scale_fields.h"
#include "names.h"
#include "wire/clock.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr std::size_t kLatencies = 256;

std::string host_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::int64_t resident_bytes() {
  std::int64_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

std::int8_t level_of(const FrameResult& last) {
  if (last.rejected) return status_t::LEVEL_ERROR;
  // A pose that is given with a reason is one to be wary of.
  const bool wary = last.state == TrackingState::kTracking && last.reason != Reason::kNone;
  return wary || last.state == TrackingState::kLost ? status_t::LEVEL_WARNING : status_t::LEVEL_OK;
}

}  // namespace

StatusBoard::StatusBoard(std::int64_t server_epoch)
    : identity_{}, period_begin_(std::chrono::steady_clock::now()) {
  identity_.start_utime = server_epoch;
  identity_.name = "eifmap-server";
  identity_.version = EIFMAP_VERSION;
  identity_.host = host_name();
  identity_.pid = static_cast<std::int32_t>(getpid());
  identity_.server_epoch = server_epoch;
}

void StatusBoard::note_frame(const FrameResult& result, TimePoint received, TimePoint published) {
  if (result.rejected) {
    ++rejected_;
    ++rejections_[result.reason];
    malformed_ += result.reason == Reason::kMalformedMessage ? 1 : 0;
    faults_ += result.reason == Reason::kInternalError ? 1 : 0;
    note_reason(result.reason, result.detail);
    return;
  }
  ++processed_;
  last_ = result;
  const float ms = std::chrono::duration<float, std::milli>(published - received).count();
  if (latencies_ms_.size() < kLatencies) {
    latencies_ms_.push_back(ms);
  } else {
    latencies_ms_[next_latency_] = ms;
    next_latency_ = (next_latency_ + 1) % kLatencies;
  }
}

void StatusBoard::note_reason(Reason reason, const std::string& detail) {
  last_.rejected = reason != Reason::kCalibrationChanged && reason != Reason::kMapReset;
  last_.reason = reason;
  last_.detail = detail;
}

void StatusBoard::note_measurement(Reason reason, const std::string& detail) {
  malformed_ += reason == Reason::kMalformedMessage ? 1 : 0;
  note_reason(reason, detail);
}

void StatusBoard::note_fault(const std::string& detail) {
  ++faults_;
  note_reason(Reason::kInternalError, detail);
}

void StatusBoard::note_resumed(std::int64_t map_id, const MapperStatistics& statistics) {
  last_.map_id = map_id;
  resumed_ = "goes on with map " + std::to_string(map_id) + ", " +
             std::to_string(statistics.keyframes) + " keyframes and " +
             std::to_string(statistics.landmarks) + " landmarks, once an image shows where it is";
}

bool StatusBoard::note_saved(const MapSaver::State& saved) {
  const bool is_news = saved_ ? saved_->is_safe != saved.is_safe : !saved.is_safe;
  saved_ = saved;
  return is_news;
}

void StatusBoard::note_parts_left(std::int64_t parts) {
  parts_left_ += parts;
}

void StatusBoard::note_new_map() {
  last_ = {};
}

float StatusBoard::latency_ms(double quantile) const {
  if (latencies_ms_.empty()) return 0;
  std::vector<float> sorted = latencies_ms_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(quantile * static_cast<double>(sorted.size() - 1))];
}

void StatusBoard::measure_rates(std::int64_t received, TimePoint now) {
  const float elapsed_s = std::chrono::duration<float>(now - period_begin_).count();
  if (elapsed_s <= 0) return;
  input_hz_ = static_cast<float>(received - period_received_) / elapsed_s;
  pose_hz_ = static_cast<float>(processed_ - period_processed_) / elapsed_s;
  period_begin_ = now;
  period_received_ = received;
  period_processed_ = processed_;
}

std::int8_t StatusBoard::state() const {
  if (stopping_) return status_t::STATE_STOPPING;
  return paused_ ? status_t::STATE_PAUSED : static_cast<std::int8_t>(last_.state);
}

void StatusBoard::describe_state(status_t& status, const std::string& camera) const {
  status.state = state();
  status.level = level_of(last_);
  status.reason = static_cast<std::int16_t>(last_.reason);
  if (stopping_) {
    status.message = "the server was told to stop";
    if (parts_left_ > 0)
      status.message += "; " + std::to_string(parts_left_) +
                        " parts of the map could not be sent in time: it is not whole";
  } else if (paused_) {
    status.level = status_t::LEVEL_WARNING;  // somebody may have forgotten it
    status.reason = static_cast<std::int16_t>(Reason::kPaused);
    status.message = "mapping is paused by command; " + std::to_string(paused_frames_) +
                     " frames were left out so far";
    status.hint = describe(Reason::kPaused).hint;
  } else if (saved_ && !saved_->is_safe && last_.state != TrackingState::kLost) {
    const ReasonText& text = describe(Reason::kMapNotSaved);
    status.level = status_t::LEVEL_ERROR;
    status.reason = static_cast<std::int16_t>(Reason::kMapNotSaved);
    status.message = std::string(text.text) + ": " + saved_->problem;
    status.hint = text.hint;
  } else if (last_.reason != Reason::kNone) {
    const ReasonText& text = describe(last_.reason);
    status.message = text.text + (last_.detail.empty() ? "" : ": " + last_.detail);
    status.hint = text.hint;
  } else if (last_.state == TrackingState::kTracking) {
    status.message = std::to_string(last_.num_inliers) + " of " +
                     std::to_string(last_.num_matches) + " map features agree with the pose";
  } else if (processed_ == 0 && !resumed_.empty()) {
    status.message = resumed_;
    status.hint = "show the camera what is mapped";
  } else if (processed_ == 0) {
    const std::string name = camera.empty() ? "<camera>" : camera;
    status.message = "no frame has arrived yet";
    status.hint = "publish eifmap." + name + ".calibration and eifmap." + name +
                  ".image or eifmap." + name + ".features";
  }
  status.message = clipped(std::move(status.message));
}

status_t StatusBoard::make(const std::string& camera, const Counts& counts,
                           const StreamBook& streams, const MapperStatistics& statistics,
                           TimePoint now, bool new_period) {
  if (new_period) measure_rates(counts.frames_received, now);
  status_t status = identity_;
  status.utime = now_us();
  status.camera = camera;
  status.rss_bytes = resident_bytes();
  describe_state(status, camera);
  describe_map(status, counts, statistics);
  describe_traffic(status, counts, streams);
  describe_last_frame(status);
  Diagnostics diagnostics(status);
  describe_mapping(statistics, diagnostics);
  describe_own(counts, diagnostics);
  describe_commands(counts.commands, diagnostics);
  describe_requests(counts.maps, diagnostics);
  describe_streams(streams, diagnostics);
  describe_measurements(counts.measurements, counts.measurements_dropped, statistics, diagnostics);
  describe_parts(counts.parts, diagnostics);
  return status;
}

void StatusBoard::describe_map(status_t& status, const Counts& counts,
                               const MapperStatistics& statistics) const {
  status.map_id = last_.map_id;
  status.map_epoch = last_.map_epoch;
  status.map_seq = counts.map_seq;
  status.map_digest = counts.map_digest;
  status.map_is_safe = saved_ && saved_->is_safe;
  status.num_landmarks = static_cast<std::int32_t>(statistics.landmarks);
  status.num_keyframes = static_cast<std::int32_t>(statistics.keyframes);
  const auto sights = statistics.nis.find(InnovationKind::kSight);
  status.nis_ratio = sights == statistics.nis.end() ? 0 : static_cast<float>(sights->second.ratio);
  write_scale(statistics.scale, status);
  write_earth(statistics.earth, status);
}

void StatusBoard::describe_traffic(status_t& status, const Counts& counts,
                                   const StreamBook& streams) const {
  status.frames_received = counts.frames_received + counts.foreign_frames;
  status.frames_processed = processed_;
  status.frames_dropped = counts.frames_dropped;
  status.frames_rejected = rejected_ + counts.foreign_frames + paused_frames_;
  status.sequence_gaps = streams.missing();
  status.bad_messages = malformed_ + counts.bad_channels;
  status.parts_sent = parts_sent_;
  status.input_hz = input_hz_;
  status.pose_hz = pose_hz_;
  status.latency_ms_p50 = latency_ms(0.5);
  status.latency_ms_p99 = latency_ms(0.99);
}

void StatusBoard::describe_last_frame(status_t& status) const {
  status.last_frame_utime = last_.time_us;
  status.num_matches = last_.num_matches;
  status.num_inliers = last_.num_inliers;
}

// What is counted here, and what others count one by one.
void StatusBoard::describe_own(const Counts& counts, Diagnostics& out) const {
  out.add("rejected.", rejections_);
  if (paused_frames_ > 0) out.add("frames.PAUSED", paused_frames_);
  if (saved_) {
    out.add("maps.saved", saved_->saved);
    out.add("maps.not_saved", saved_->failures);
  }
  out.add("moving.now", std::int64_t{last_.num_moving});
  out.add("send_failures", send_failures_);
  out.add("parts_dropped", counts.maps.parts_dropped + parts_left_);
  out.add("internal_errors", faults_);
  out.add("calibration_guessed", std::int64_t{counts.calibration_is_guessed});
}

}  // namespace eifmap
