// Runs the mapper's keyframe jobs in a thread of its own, so that mapping never delays a pose.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "keyframe_job.h"

namespace eifmap {

// When a job's map is adopted.
struct Handover {
  enum class When {
    kAtOnce,       // process() does the mapping itself: no worker
    kWhenDone,     // before the first frame after it is done: decided by timing
    kAfterFrames,  // before the n-th frame after its own, waited for: decided by count
    kAsRecorded    // before the frames that a recorded run adopted one before, waited for
  };
  When when = When::kAtOnce;
  int frames = 0;                                     // n
  std::function<bool(const FeatureFrame&)> recorded;  // whether one was adopted before this frame
  // Called in the worker's thread before a job runs and after it: where tests delay it.
  std::function<void()> around_job = {};
  bool is_beside() const { return when != When::kAtOnce; }
};

class KeyframeWorker : public KeyframeRunner {
 public:
  // One that is beside. The thread starts with the first job.
  explicit KeyframeWorker(Handover handover);
  ~KeyframeWorker() override;
  KeyframeWorker(const KeyframeWorker&) = delete;
  KeyframeWorker& operator=(const KeyframeWorker&) = delete;

  void start(KeyframeJob job) override;
  bool due(const FeatureFrame& frame) override;
  // Rethrows what the job threw, which is gone then.
  KeyframeJob finish() override;

  bool has_job() const;  // running, or done and not finished
  bool is_done() const;
  // It is done, and need not wait for a frame: nobody counts or has recorded any.
  bool may_be_adopted() const;
  // Waits for a job that nobody wants any more.
  void discard();
  // Wall time of the jobs since the last call, ms.
  double take_busy_ms();

 private:
  void run();
  void wait_until_done(std::unique_lock<std::mutex>& lock);

  const Handover handover_;
  int frames_since_start_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<KeyframeJob> job_;
  std::exception_ptr failure_;
  bool done_ = false, closing_ = false;
  double busy_ms_ = 0;
  std::thread thread_;
};

}  // namespace eifmap
