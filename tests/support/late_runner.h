// A runner of keyframes' jobs that is late by so many frames, the same each time.
#pragma once

#include <optional>
#include <utility>

#include "keyframe_job.h"

namespace eifmap::test {

// Adopts each job before the n-th frame after its own, and runs it then.
class LateRunner : public KeyframeRunner {
 public:
  explicit LateRunner(int n) : n_(n) {}
  void start(KeyframeJob job) override { job_.emplace(std::move(job)), since_ = 0; }
  bool due(const FeatureFrame&) override { return ++since_ == n_; }
  KeyframeJob finish() override {
    KeyframeJob job = std::move(*job_);
    job_.reset();
    job.run();
    return job;
  }

 private:
  int n_, since_ = 0;
  std::optional<KeyframeJob> job_;
};

}  // namespace eifmap::test
