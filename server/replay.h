// A live run made again from its images and its decisions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "decision.h"
#include "server/keyframe_worker.h"

namespace eifmap {

class Replay {
 public:
  // `measurements`: of that run; "" none. Returns "" or what is wrong with the files.
  std::string open(const std::filesystem::path& decisions,
                   const std::filesystem::path& measurements);
  bool is_open() const { return !decisions_.empty(); }

  bool takes(std::int64_t time_us) const { return decisions_.contains(time_us); }
  // Whether the map was given up before this frame, which is taken.
  bool resets_before(std::int64_t time_us) const { return decisions_.at(time_us).after_reset; }
  Handover handover() const;  // which must not outlive this

  // Of a frame that is taken, what its publisher told: who it is, since another one ends a stream.
  void restore(FeatureFrame& frame) const;
  // Those that the mapper took before this frame, which is taken. Of one that is not in the file,
  // departure() will speak.
  std::vector<AbsoluteMeasurement> measurements_before(std::int64_t time_us);
  // Of each frame, in turn.
  void compare(const FrameResult& result);
  // "" while every frame came out as recorded, and none of the recorded ones and of their
  // measurements is missing.
  std::string departure() const;

 private:
  std::filesystem::path file_;
  std::map<std::int64_t, Decision> decisions_;  // by the frame's time, us
  bool at_once_ = false;                        // a run without jobs
  std::filesystem::path measurements_file_;
  std::map<MeasurementId, AbsoluteMeasurement> measurements_;
  std::int64_t compared_ = 0, measured_ = 0, missing_ = 0;
  std::string departure_;
};

}  // namespace eifmap
