#include "bus/outbox.h"

#include <algorithm>

namespace eifmap {

void Outbox::push(std::string channel, std::vector<std::uint8_t> bytes) {
  auto message = std::make_shared<OutgoingMessage>();
  message->channel = std::move(channel);
  message->bytes = std::move(bytes);
  push(std::move(message));
}

void Outbox::push(std::shared_ptr<OutgoingMessage> message) {
  message->waits = true;
  waiting_.push_back(std::move(message));
}

std::int64_t Outbox::drop_all() {
  for (const auto& message : waiting_) message->waits = false;
  const auto dropped = static_cast<std::int64_t>(waiting_.size());
  waiting_.clear();
  return dropped;
}

std::optional<Outbox::TimePoint> Outbox::send_due(TimePoint now, const Send& send) {
  paid_until_ = std::max(paid_until_, now - duration(kBurstBytes));
  while (!waiting_.empty() && paid_until_ <= now) {
    // Out first: what throws when it is sent must not be tried for ever.
    const auto next = std::move(waiting_.front());
    waiting_.pop_front();
    next->waits = false;
    next->sent_at = now;
    paid_until_ += duration(next->bytes.size());
    send(next->channel, next->bytes);
  }
  if (waiting_.empty()) return {};
  return paid_until_;
}

}  // namespace eifmap
