#include "client/view/page_queue.h"

#include <utility>

namespace eifmap {

void PageQueue::push(SharedMessage increment) {
  if (wants_snapshot_) return;  // which will have this in it
  bytes_ += increment->bytes.size();
  increments_.push_back(std::move(increment));
  if (bytes_ <= max_bytes_) return;
  increments_.clear();
  bytes_ = 0;
  wants_snapshot_ = true;
}

void PageQueue::push_picture(SharedMessage picture) {
  picture_ = std::move(picture);
}

SharedMessage PageQueue::pop(const std::function<SharedMessage()>& snapshot) {
  if (std::exchange(wants_snapshot_, false)) return snapshot();
  if (increments_.empty()) return std::exchange(picture_, nullptr);
  SharedMessage first = std::move(increments_.front());
  increments_.pop_front();
  bytes_ -= first->bytes.size();
  return first;
}

}  // namespace eifmap
