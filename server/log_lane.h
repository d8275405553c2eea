// One camera of an event log, mapped again: as a run of the server decided, or, where no decisions
// are known, every frame.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "server/camera_mapper.h"
#include "server/log_contents.h"

namespace eifmap {

class LogLane {
 public:
  // `config`: with the camera. `contents`: of the camera, which must outlive this; `epoch`: the run
  // of it that decides; `obeys`: or there is none, and every frame is mapped.
  LogLane(const ServerConfig& config, const LogContents::Camera& contents, std::int64_t epoch,
          bool obeys);

  void take_calibration(Bytes bytes) { mapper_.take_calibration(camera_, bytes); }
  void take_measurement(Bytes bytes);  // where it comes; of a run they come where it had them
  void take_frame(ChannelKind kind, Bytes bytes);
  void finish();  // adopts what is still beside

  std::int64_t mapped() const { return mapped_; }
  bool has_results() const { return mapper_.has_results(); }
  std::string write_results(const std::filesystem::path& folder) const {
    return mapper_.write_results(folder);
  }

  // What is not as it was in that run, a sentence each, what caused it first; nothing: every frame
  // came out with the recorded digest. After finish().
  std::vector<std::string> departures() const;

 private:
  ServerConfig with_camera(const ServerConfig& config) const;
  Handover handover(const ServerConfig& config) const;
  const Decision* decision_on(ChannelKind kind, Bytes bytes);
  void give_measurements(const Decision& decision);
  void obey(const Decision& decision, ChannelKind kind, Bytes bytes);
  void compare(const Decision& decision, const FrameResult& result);
  std::string what_is_missing() const;

  const std::string camera_;
  const bool obeys_;
  const LogContents::Camera& contents_;
  static const LogContents::Run kNoRun;
  const LogContents::Run& run_;
  // Of the frames still to come. One frame has several where a server began to map anew and was
  // sent the same again.
  std::map<FrameName, std::deque<const Decision*>> open_;
  const Decision* current_ = nullptr;  // on the frame in work
  CameraMapper mapper_;
  std::int64_t mapped_ = 0, measurements_missing_ = 0;
  std::string first_other_;  // the first digest that differs
};

}  // namespace eifmap
