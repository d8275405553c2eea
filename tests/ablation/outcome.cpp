#include "ablation/outcome.h"

#include <algorithm>

#include "consistency/judgement.h"
#include "sequence/trajectory_error.h"
#include "server/jitter.h"

namespace eifmap::test {
namespace {

class JitteredSource : public FrameSource {
 public:
  JitteredSource(const Recording& recording, const FeatureSet& features, std::uint64_t seed)
      : recording_(recording), frames_(features.frames) {
    Jitter jitter(kJitterPx, seed);
    for (FeatureFrame& frame : frames_) jitter.apply(frame);
  }

  int size() const override { return static_cast<int>(frames_.size()); }
  const Camera& camera() const override { return recording_.camera; }
  std::int64_t time_us(int i) const override { return frames_[i].time_us; }
  std::optional<Rigid3> world_from_camera(int i) const override {
    if (!recording_.truth_is_exact) return std::nullopt;
    return recording_.world_from_camera(static_cast<int>(frames_[i].seq));
  }
  FeatureFrame frame(int i) const override { return frames_[i]; }

 private:
  const Recording& recording_;
  std::vector<FeatureFrame> frames_;
};

TrajectoryError error_of(const Recording& recording, const JudgedRun& run) {
  std::vector<TumPose> estimate;
  for (const TimedPose& pose : run.final_trajectory)
    estimate.push_back({1e-6 * static_cast<double>(pose.time_us), pose.world_from_camera});
  TrajectoryErrorOptions options;
  options.num_frames = run.frames;
  return trajectory_error(recording.truth, estimate, options);
}

}  // namespace

Outcome run_once(const Recording& recording, const FeatureSet& features,
                 const MapperOptions& options, std::uint64_t seed) {
  const JudgedRun run = judge_run(JitteredSource(recording, features, seed), options);
  const TrajectoryError error = error_of(recording, run);
  Outcome outcome;
  outcome.frames = run.frames;
  if (error.aligned) outcome.ate_m = error.rmse_m;
  outcome.coverage = error.coverage.value_or(0);
  if (recording.truth_is_exact) outcome.nees = mean_nees(run.keyframes);
  outcome.extraction_ms = features.cpu_ms;
  outcome.mapper_ms = 1000 * run.mapper_cpu_s / std::max(1, run.frames);
  outcome.statistics = run.statistics;
  return outcome;
}

}  // namespace eifmap::test
