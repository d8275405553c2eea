#include "server/inbox.h"

#include <algorithm>

#include "wire/clock.h"

namespace eifmap {

// Throws out what a newer one takes the place of.
void Inbox::replace(const Channel& channel) {
  std::erase_if(queue_, [&](const Received& waiting) {
    const bool frames = is_frame(waiting.channel) && is_frame(channel);
    if (waiting.channel != channel && !frames) return false;
    queued_bytes_ -= waiting.bytes.size();
    if (frames) {
      ++counts_.dropped;
      dropped_since_put_ += 1 + waiting.dropped_before;
    }
    return true;
  });
}

void Inbox::put(const Channel& channel, Bytes bytes, bool may_wait) {
  std::unique_lock lock(mutex_);
  if (mode_ == InputMode::kNewest && !each_counts(channel.kind)) replace(channel);
  const auto has_room = [&] {
    return closed_ || queue_.empty() || queued_bytes_ + bytes.size() <= max_bytes_;
  };
  if (mode_ == InputMode::kLossless && may_wait) changed_.wait(lock, has_room);
  if (closed_) return;
  const bool frame = is_frame(channel);
  counts_.frames += frame ? 1 : 0;
  if (!has_room()) {
    counts_.dropped += frame ? 1 : 0;
    dropped_since_put_ += frame ? 1 : 0;
    counts_.measurements_dropped += channel.kind == ChannelKind::kMeasurement ? 1 : 0;
    return;
  }
  queue_.push_back({channel,
                    {bytes.begin(), bytes.end()},
                    std::chrono::steady_clock::now(),
                    now_us(),
                    frame ? std::exchange(dropped_since_put_, 0) : 0});
  queued_bytes_ += bytes.size();
  changed_.notify_all();
}

std::optional<Received> Inbox::take(TimePoint deadline) {
  std::unique_lock lock(mutex_);
  taker_waits_ = true;
  changed_.notify_all();
  changed_.wait_until(lock, deadline, [this] { return closed_ || !queue_.empty(); });
  if (closed_ || queue_.empty()) return {};
  taker_waits_ = false;
  Received next = std::move(queue_.front());
  queue_.pop_front();
  queued_bytes_ -= next.bytes.size();
  changed_.notify_all();
  return next;
}

void Inbox::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

bool Inbox::wait_until_idle(TimePoint deadline) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, deadline,
                             [this] { return closed_ || (queue_.empty() && taker_waits_); });
}

Inbox::Counts Inbox::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

}  // namespace eifmap
