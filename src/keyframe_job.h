// A keyframe's way into the map as a piece of work of its own: the frames that come meanwhile are
// tracked on the map as it was, so that mapping never delays a pose. Who owns the mapper says when
// the result is adopted; the mapper itself knows no thread and no clock.
#pragma once

#include <cstdint>
#include <memory>

#include "frame.h"

namespace eifmap {

struct KeyframeWork;  // map/keyframe_work.h

// Shares nothing that anybody changes: run() is good in any thread.
class KeyframeJob {
 public:
  explicit KeyframeJob(std::unique_ptr<KeyframeWork> work);
  ~KeyframeJob();
  KeyframeJob(KeyframeJob&&) noexcept;
  KeyframeJob& operator=(KeyframeJob&&) noexcept;

  std::int64_t id() const;  // counts from 1 in each mapper
  void run();

  KeyframeWork& work() { return *work_; }  // for the mapper

 private:
  std::unique_ptr<KeyframeWork> work_;
};

// Who runs the jobs of a mapper, and says when they are adopted.
class KeyframeRunner {
 public:
  virtual ~KeyframeRunner() = default;
  // Never while another is not finished.
  virtual void start(KeyframeJob job) = 0;
  // Whether the job that was started is to be adopted before this frame. Asked once for each frame
  // while there is one.
  virtual bool due(const FeatureFrame& frame) = 0;
  // The job, run; waits for that.
  virtual KeyframeJob finish() = 0;
};

}  // namespace eifmap
