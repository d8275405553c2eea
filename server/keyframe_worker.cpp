#include "server/keyframe_worker.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <utility>

namespace eifmap {
namespace {

// Where cores are few, whoever waits for a pose goes first. Linux keeps this by thread.
void yield_to_tracking() {
  constexpr int kNicer = 5;
  const auto thread = static_cast<id_t>(gettid());
  static_cast<void>(setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + kNicer));
}

}  // namespace

KeyframeWorker::KeyframeWorker(Handover handover) : handover_(std::move(handover)) {
  if (!handover_.is_beside())
    throw std::invalid_argument("KeyframeWorker: at once needs no worker");
  if (handover_.when == Handover::When::kAsRecorded && !handover_.recorded)
    throw std::invalid_argument("KeyframeWorker: as recorded needs the record");
}

KeyframeWorker::~KeyframeWorker() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void KeyframeWorker::start(KeyframeJob job) {
  // First: were there none for the job, finish() would wait for ever.
  if (!thread_.joinable()) thread_ = std::thread(&KeyframeWorker::run, this);
  {
    const std::lock_guard lock(mutex_);
    if (job_) throw std::invalid_argument("KeyframeWorker: a job is not finished");
    job_.emplace(std::move(job));
    done_ = false;
    failure_ = nullptr;
  }
  frames_since_start_ = 0;
  changed_.notify_all();
}

bool KeyframeWorker::due(const FeatureFrame& frame) {
  ++frames_since_start_;
  switch (handover_.when) {
    case Handover::When::kAsRecorded:
      return handover_.recorded(frame);
    case Handover::When::kAfterFrames:
      return frames_since_start_ >= handover_.frames;
    default:
      return is_done();
  }
}

void KeyframeWorker::wait_until_done(std::unique_lock<std::mutex>& lock) {
  changed_.wait(lock, [this] { return done_; });
}

KeyframeJob KeyframeWorker::finish() {
  std::unique_lock lock(mutex_);
  if (!job_) throw std::invalid_argument("KeyframeWorker: no job was started");
  wait_until_done(lock);
  KeyframeJob job = std::move(*job_);
  job_.reset();
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  return job;
}

bool KeyframeWorker::has_job() const {
  const std::lock_guard lock(mutex_);
  return job_.has_value();
}

bool KeyframeWorker::may_be_adopted() const {
  return handover_.when == Handover::When::kWhenDone && is_done();
}

bool KeyframeWorker::is_done() const {
  const std::lock_guard lock(mutex_);
  return job_ && done_;
}

void KeyframeWorker::discard() {
  std::unique_lock lock(mutex_);
  if (!job_) return;
  wait_until_done(lock);
  job_.reset();
}

double KeyframeWorker::take_busy_ms() {
  const std::lock_guard lock(mutex_);
  return std::exchange(busy_ms_, 0.0);
}

void KeyframeWorker::run() {
  using Clock = std::chrono::steady_clock;
  yield_to_tracking();
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return closing_ || (job_ && !done_); });
    if (closing_) return;
    KeyframeJob& job = *job_;  // nobody else touches it before it is done
    lock.unlock();
    const Clock::time_point begin = Clock::now();
    std::exception_ptr failure;
    try {
      if (handover_.around_job) handover_.around_job();
      job.run();
      if (handover_.around_job) handover_.around_job();
    } catch (...) {
      failure = std::current_exception();
    }
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    lock.lock();
    busy_ms_ += ms;
    failure_ = failure;
    done_ = true;
    changed_.notify_all();
  }
}

}  // namespace eifmap
