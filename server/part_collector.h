// A camera's feature frames that come in parts, made whole on their way to its inbox.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>

#include "convert/feature_parts.h"

namespace eifmap {

class PartCollector {
 public:
  using Clock = std::chrono::steady_clock;
  // Takes a feature frame as a message; called by one thread at a time, frames in the order of
  // their capture. `may_wait`: for room, as take() was told.
  using Deliver = std::function<void(Bytes frame, bool may_wait)>;

  explicit PartCollector(Deliver deliver) : deliver_(std::move(deliver)) {}

  // A message of the camera's feature channel. Whole frames are delivered at once, after what is in
  // work. So is a message that is no good part: it is refused and counted where all are.
  void take(Bytes message, Clock::time_point now, bool may_wait = true);

  // Delivers, without what is missing, frames of which nothing has come for kSilence. Not while
  // another thread is in take(): then there is no silence. For any thread, best for the one that
  // has nothing else to do; it makes room, so that it must not wait for any.
  void give_up_silent(Clock::time_point now);

  // Of all frames that came in parts. For any thread; never waits for a delivery.
  FeatureAssembler::Counts counts() const;

  // Far above the time between two parts of one frame, on any link that is of use.
  static constexpr auto kSilence = std::chrono::milliseconds(200);

 private:
  void deliver(const FeatureFrame& frame, bool may_wait);
  void finish(bool may_wait);
  void publish_counts();

  const Deliver deliver_;
  std::mutex work_mutex_;  // held during deliveries
  FeatureAssembler assembler_;
  Clock::time_point last_part_;
  mutable std::mutex counts_mutex_;  // held for moments
  FeatureAssembler::Counts counts_;
};

}  // namespace eifmap
