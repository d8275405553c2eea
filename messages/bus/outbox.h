// Messages that leave at a pace the receivers' buffers keep up with.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace eifmap {

// One that may have to be sent again: whoever keeps it sees what became of it.
struct OutgoingMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  bool waits = false;                               // in an outbox
  std::chrono::steady_clock::time_point sent_at{};  // last
};

class Outbox {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  using Send = std::function<void(const std::string& channel, const std::vector<std::uint8_t>&)>;

  explicit Outbox(int bytes_per_s) : bytes_per_s_(bytes_per_s) {}

  void push(std::string channel, std::vector<std::uint8_t> bytes);
  void push(std::shared_ptr<OutgoingMessage> message);  // once: not while it waits

  // Sends what may be sent by now, in the order it was pushed: the pace, plus a burst of at most
  // kBurstBytes after a silence. Returns when the next may go, or nothing when none is left.
  std::optional<TimePoint> send_due(TimePoint now, const Send& send);

  // Throws out what waits; returns how many messages.
  std::int64_t drop_all();

  // About what the stock receive buffer of a socket holds, half of it.
  static constexpr int kBurstBytes = 96 * 1024;

 private:
  std::chrono::nanoseconds duration(std::size_t bytes) const {
    return std::chrono::nanoseconds(
        static_cast<std::int64_t>(1e9 * static_cast<double>(bytes) / bytes_per_s_));
  }

  int bytes_per_s_;
  std::deque<std::shared_ptr<OutgoingMessage>> waiting_;
  TimePoint paid_until_{};  // when all that was sent will have been sent at the pace
};

}  // namespace eifmap
