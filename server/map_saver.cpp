#include "server/map_saver.h"

#include <exception>
#include <utility>

namespace eifmap {

MapSaver::~MapSaver() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void MapSaver::save(MapperSnapshot snapshot, const Camera& camera, std::int64_t seq) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = Job{std::move(snapshot), camera, seq};
  }
  changed_.notify_all();
  if (!thread_.joinable()) thread_ = std::thread(&MapSaver::run, this);
}

void MapSaver::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return waiting_ || closing_; });
    if (!waiting_) return;
    const Job job = std::move(*waiting_);
    waiting_.reset();
    works_ = true;
    lock.unlock();
    std::string problem;
    try {
      problem = store_.save(job.snapshot, job.camera, job.seq);
    } catch (const std::exception& error) {
      problem = error.what();  // memory: as a full disk
    }
    lock.lock();
    works_ = false;
    state_.seq = job.seq;
    state_.is_safe = problem.empty();
    ++(problem.empty() ? state_.saved : state_.failures);
    state_.problem = std::move(problem);
    changed_.notify_all();
  }
}

MapSaver::State MapSaver::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void MapSaver::wait_until_idle() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !waiting_ && !works_; });
}

}  // namespace eifmap
