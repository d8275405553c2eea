// What others want done in a mapping thread, between two frames: it does not wait behind frames.
#pragma once

#include <functional>
#include <mutex>
#include <utility>
#include <vector>

namespace eifmap {

class OrderQueue {
 public:
  using Order = std::function<void()>;

  // More never wait.
  static constexpr std::size_t kMost = 100;

  // From any thread. False when it will not be done: too many wait, or it is closed.
  bool push(Order order) {
    const std::lock_guard lock(mutex_);
    if (closed_ || waiting_.size() == kMost) return false;
    waiting_.push_back(std::move(order));
    return true;
  }

  // Those that wait, in turn.
  std::vector<Order> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }

  // Nothing more goes in, and what waits is thrown out.
  void close() {
    std::vector<Order> gone;  // destroyed after the lock is: what they hold may be anything
    const std::lock_guard lock(mutex_);
    closed_ = true;
    gone.swap(waiting_);
  }

 private:
  std::mutex mutex_;
  std::vector<Order> waiting_;
  bool closed_ = false;
};

}  // namespace eifmap
