// What a run leaves behind: trajectories, map and report.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "decision.h"
#include "mapper.h"
#include "published_path.h"
#include "server/step_timer.h"

namespace eifmap {

// Whether what results are written from is noted, frame by frame: who runs for months and asks for
// none needs none of it.
enum class Results { kKept, kNone };

// Poses as they were published, gathered frame by frame.
class RunRecord {
 public:
  // `result`: also of a frame that never reached the mapper (result.rejected, with its reason).
  void add(const FrameResult& result);

  // One that the mapper took.
  void add(const AbsoluteMeasurement& measurement) { measurements_.push_back(measurement); }

  // An image was extracted in which the camera's roll could not be seen, although it was sought
  // (FeatureExtractor::roll_is_sure).
  void add_unseen_roll() { ++rolls_unseen_; }

  // Writes, in metres where a map's scale is known in the end, trajectory.tum,
  // trajectory_final.tum, keyframes.tum, decisions.jsonl, measurements.jsonl (where there are any),
  // map.ply and report.json into `folder`, made when it is not there. Returns "" or what went
  // wrong.
  std::string write(const std::filesystem::path& folder, const Mapper& mapper,
                    const StepTimer& timer, const std::string& source) const;

  int frames() const { return frames_; }

 private:
  std::int64_t num_of_this_run(const std::vector<TimedPose>& trajectory) const;

  int frames_ = 0;  // offered, rejected ones too
  int rolls_unseen_ = 0;
  std::map<Reason, std::int64_t> rejected_;
  PublishedPath path_;
  std::vector<Decision> decisions_;
  std::vector<AbsoluteMeasurement> measurements_;
};

// Makes the folder, and returns "" or why nothing can be written there: before the work, not after.
std::string output_problem(const std::filesystem::path& folder);

// Of this process so far, every thread.
double process_cpu_seconds();
double peak_rss_mib();

}  // namespace eifmap
