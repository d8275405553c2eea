#include "server/inbox.h"

#include <algorithm>

#include "wire/clock.h"

namespace eifmap {

// Throws out what the predicate names; returns how many.
template <class Predicate>
std::int64_t Inbox::remove(Predicate predicate) {
  const std::size_t before = queue_.size();
  std::erase_if(queue_, [&](const Received& waiting) {
    if (!predicate(waiting.channel)) return false;
    queued_bytes_ -= waiting.bytes.size();
    return true;
  });
  return static_cast<std::int64_t>(before - queue_.size());
}

void Inbox::put(const Channel& channel, Bytes bytes, bool may_wait) {
  std::unique_lock lock(mutex_);
  if (is_foreign(channel)) {
    counts_.foreign += is_frame(channel) ? 1 : 0;
    return;
  }
  if (mode_ == InputMode::kNewest && !each_counts(channel.kind)) {
    const std::int64_t replaced = remove([&](const Channel& waiting) {
      return waiting == channel ||
             (is_frame(waiting) && is_frame(channel) && waiting.camera == channel.camera);
    });
    if (is_frame(channel)) {
      counts_.dropped += replaced;
      dropped_since_take_ += replaced;
    }
  }
  const auto has_room = [&] {
    return closed_ || queue_.empty() || queued_bytes_ + bytes.size() <= max_bytes_;
  };
  if (mode_ == InputMode::kLossless && may_wait) changed_.wait(lock, has_room);
  if (closed_) return;
  counts_.frames += is_frame(channel) ? 1 : 0;
  if (!has_room()) {  // many cameras, before one is selected; or nobody who could wait
    counts_.dropped += is_frame(channel) ? 1 : 0;
    counts_.measurements_dropped += channel.kind == ChannelKind::kMeasurement ? 1 : 0;
    return;
  }
  queue_.push_back(
      {channel, {bytes.begin(), bytes.end()}, std::chrono::steady_clock::now(), now_us(), 0});
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
  if (is_frame(next.channel)) next.dropped_before = std::exchange(dropped_since_take_, 0);
  changed_.notify_all();
  return next;
}

void Inbox::select_camera(const std::string& camera) {
  const std::lock_guard lock(mutex_);
  camera_ = camera;
  const std::int64_t frames =
      remove([this](const Channel& waiting) { return is_foreign(waiting) && is_frame(waiting); });
  remove([this](const Channel& waiting) { return is_foreign(waiting); });
  counts_.frames -= frames;
  counts_.foreign += frames;
  changed_.notify_all();
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
